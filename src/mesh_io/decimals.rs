//! Coordinates of text files: the type that stores them without loss.

use super::error::FileError;
use super::text::quote;
use alloc::format;

/// A coordinate in a text file: the nearest `f64`.
pub(super) fn coordinate(word: Option<&str>, line: usize) -> Result<f64, FileError> {
    let word = word.ok_or_else(|| FileError::line(line, "a number is missing"))?;
    match word.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) => Err(FileError::line(line, format!("the coordinate {} is not finite", quote(word)))),
        Err(_) => Err(FileError::line(line, format!("{} is not a number", quote(word)))),
    }
}

/// Tracks whether the coordinates read so far lose nothing as `f32`.
#[derive(Default)]
pub(super) struct Decimals {
    need_f64: bool,
}

impl Decimals {
    pub(super) fn coordinate(&mut self, word: Option<&str>, line: usize) -> Result<f64, FileError> {
        let x = coordinate(word, line)?;
        self.need_f64 = self.need_f64 || !word.is_some_and(|word| survives_f32(word, x));
        Ok(x)
    }

    pub(super) fn point<'a>(
        &mut self,
        words: &mut impl Iterator<Item = &'a str>,
        line: usize,
    ) -> Result<[f64; 3], FileError> {
        let mut next = || self.coordinate(words.next(), line);
        Ok([next()?, next()?, next()?])
    }

    /// Rounds the points of a whole file, if that loses nothing.
    pub(super) fn settle(&self, points: &mut [[f64; 3]]) {
        if !self.need_f64 {
            points.as_flattened_mut().iter_mut().for_each(|x| *x = f64::from(*x as f32));
        }
    }
}

/// Whether a decimal number, whose `f64` is `x`, can be reproduced from its `f32` digit by digit.
fn survives_f32(word: &str, x: f64) -> bool {
    let single = x as f32;
    if f64::from(single) == x {
        return true;
    }
    let digits = |word: &str| {
        let mantissa = word.split(['e', 'E']).next().unwrap_or("");
        mantissa.trim_start_matches(['+', '-', '0', '.']).bytes().filter(u8::is_ascii_digit).count()
    };
    let count = digits(word);
    // One digit stands before the point. Printers differ in rounding a number half way between two of that many digits.
    let (rounded, shortest) = (format!("{single:.*e}", count.saturating_sub(1)), format!("{single:e}"));
    [rounded, shortest].iter().any(|print| digits(print) == count && print.parse() == Ok(x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn decimals_become_the_nearest_double() {
        // 2^53 + 1 lies half way and rounds to even. 5e-324 is the smallest positive number.
        for (word, want) in
            [("0.1", 0.1), ("-.5", -0.5), ("1.", 1.0), ("9007199254740993", 9007199254740992.0)]
        {
            assert_eq!(coordinate(Some(word), 1), Ok(want));
        }
        assert_eq!(coordinate(Some("5e-324"), 1).unwrap().to_bits(), 1);
        for word in ["nan", "-inf", "1e999"] {
            let problem = format!("the coordinate '{word}' is not finite");
            assert_eq!(coordinate(Some(word), 7), Err(FileError::line(7, problem)));
        }
    }

    /// The expected loss is computed without digits: from the neighbouring `f32`s, and the distance of the number to
    /// them.
    #[test]
    fn six_digits_survive_f32_and_seventeen_do_not() {
        let survives = |word: &str| survives_f32(word, word.parse().unwrap());
        let mut rng = Rng::new(1);
        let mut random = || rng.u64() >> 11;
        for _ in 0..10_000 {
            let (mantissa, exponent) = (100_000 + random() % 900_000, (random() % 60) as i32 - 36);
            assert!(survives(&format!("-{mantissa}e{exponent}")));
            let single = f32::from_bits(0x3000_0000 + (random() % 0x2000_0000) as u32);
            for word in [format!("{single:e}"), format!("{single:.8e}"), format!("{:?}", f64::from(single))] {
                assert!(survives(&word), "{word}");
            }
            // A tenth of the way to the next `f32`: not an `f32` itself, for any number of digits that distinguish the
            // two.
            let step = f64::from(single.next_up()) - f64::from(single);
            assert!(!survives(&format!("{:.12e}", f64::from(single) + 0.1 * step)));
        }
        for (word, want) in [
            ("0.1", true),
            ("00.100000", true),
            ("+1.E-1", true),
            ("0.100000001", true),
            ("0.10000000149011612", true),
            ("0.10000000000", false),
            ("0.1000000014901", true),
            ("16777217", false),
            // Zeros before the point may be significant.
            ("115486832", true),
            ("115486830", false),
            ("142838.62", true),
            ("142838.63", true),
            ("142838.65", false),
            ("1e-50", false),
            ("1e39", false),
            ("-0", true),
            ("0e9", true),
        ] {
            assert_eq!(survives(word), want, "{word}");
        }
    }
}
