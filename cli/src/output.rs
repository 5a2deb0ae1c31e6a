//! Writes files atomically: after a full disk, a size limit or a kill, the previous contents remain.

use super::error::Error;
use std::io::Write;
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Writes the bytes of each file. No file is replaced before all are written.
pub(super) fn replace<'a>(files: impl IntoIterator<Item = (&'a Path, &'a [u8])>) -> Result<(), Error> {
    let staged: Vec<Staged<'a>> =
        files.into_iter().map(|(path, bytes)| stage(path, bytes)).collect::<Result<_, _>>()?;
    staged.into_iter().try_for_each(Staged::commit)
}

/// Bytes that will become a file's contents.
enum Staged<'a> {
    /// In a temporary file beside the one to replace.
    Beside { file: NamedTempFile, target: PathBuf },
    /// For a target that is not a file: the standard output, a pipe, a device.
    Stream { path: &'a Path, bytes: &'a [u8] },
}

/// Writes the bytes to a temporary file, which a rename then moves to `path`.
fn stage<'a>(path: &'a Path, bytes: &'a [u8]) -> Result<Staged<'a>, Error> {
    let old = std::fs::metadata(path);
    if is_standard_output(path) || old.as_ref().is_ok_and(|old| !old.is_file() && !old.is_dir()) {
        return Ok(Staged::Stream { path, bytes });
    }
    // If `path` is a symbolic link, replace its target.
    let target = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let write = || {
        let name = target.file_name().ok_or(std::io::ErrorKind::IsADirectory)?;
        let mut prefix = std::ffi::OsString::from(".");
        prefix.push(name);
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix).suffix(".part");
        #[cfg(unix)]
        // The default permissions of a new file; the process's umask applies.
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let mut file = builder.tempfile_in(folder(&target))?;
        file.write_all(bytes)?;
        if let Ok(old) = old {
            file.as_file().set_permissions(old.permissions())?;
        }
        file.as_file().sync_all()?;
        Ok(file)
    };
    let file = write().map_err(Error::io(path))?;
    Ok(Staged::Beside { file, target })
}

impl Staged<'_> {
    /// Moves the bytes to their place.
    fn commit(self) -> Result<(), Error> {
        match self {
            Self::Beside { file, target } => {
                file.persist(&target)
                    .map_err(|problem| Error::Io { path: target.clone(), error: problem.error })?;
                // Makes the rename durable. Not every file system supports this.
                let _ = std::fs::File::open(folder(&target)).and_then(|folder| folder.sync_all());
                Ok(())
            }
            Self::Stream { path, bytes } if is_standard_output(path) => {
                let mut out = std::io::stdout().lock();
                out.write_all(bytes).and_then(|()| out.flush()).map_err(Error::io(path))
            }
            Self::Stream { path, bytes } => {
                let file = std::fs::OpenOptions::new().write(true).open(path);
                file.and_then(|mut file| file.write_all(bytes)).map_err(Error::io(path))
            }
        }
    }
}

/// Prints the message about a written file to the standard output, unless that is where the file goes.
pub(super) fn say(
    file: Option<&Path>,
    print: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), Error> {
    if file.is_some_and(is_standard_output) {
        let _ = print(&mut std::io::stderr().lock());
        return Ok(());
    }
    print(&mut std::io::stdout().lock()).map_err(Error::Output)
}

/// Says how many rows of a table are left out, if any are.
pub(super) fn rest(out: &mut impl Write, all: usize, rows: usize) -> std::io::Result<()> {
    match all.saturating_sub(rows) {
        0 => Ok(()),
        more => writeln!(out, "   ... and {more} more: --rows or --json shows them"),
    }
}

/// Rejects writing one file twice, or overwriting the one that is read. The names are those of the options.
pub(super) fn check_targets(
    read: Option<&Path>,
    [first, second]: [(&'static str, Option<&Path>); 2],
) -> Result<(), Error> {
    let refuse = |option, problem| Err(Error::Option { option, problem });
    for (option, target) in [first, second] {
        if let (Some(read), Some(target)) = (read, target)
            && is_same(target, read)
        {
            return refuse(option, format!("{} is the file that is read", read.display()));
        }
    }
    match (first, second) {
        ((name, Some(one)), (option, Some(other))) if is_same(one, other) => {
            refuse(option, format!("{} is the file of {name}", other.display()))
        }
        _ => Ok(()),
    }
}

/// The folder of a file, which may not exist yet.
pub(super) fn folder(target: &Path) -> &Path {
    target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Whether two paths name one file, which may not exist yet.
pub(super) fn is_same(a: &Path, b: &Path) -> bool {
    match (std::fs::metadata(a), std::fs::metadata(b)) {
        (Ok(a_data), Ok(b_data)) => identity(a, &a_data) == identity(b, &b_data),
        (Err(_), Err(_)) => {
            let place =
                |path: &Path| Some((std::fs::canonicalize(folder(path)).ok()?, path.file_name()?.to_owned()));
            place(a).is_some_and(|of_a| Some(of_a) == place(b))
        }
        _ => false,
    }
}

/// Whether a path, such as `/dev/stdout`, names the target of the standard output.
pub(super) fn is_standard_output(path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::fd::AsFd;
        let of_output = std::io::stdout().as_fd().try_clone_to_owned().map(std::fs::File::from);
        let of_output = of_output.and_then(|output| output.metadata());
        let (Ok(of_output), Ok(of_path)) = (of_output, std::fs::metadata(path)) else { return false };
        identity(path, &of_output) == identity(path, &of_path)
    }
    #[cfg(not(unix))]
    {
        let _ = path;
        false
    }
}

#[cfg(unix)]
fn identity(_: &Path, data: &std::fs::Metadata) -> impl PartialEq + use<> {
    use std::os::unix::fs::MetadataExt;
    (data.dev(), data.ino())
}

#[cfg(not(unix))]
fn identity(path: &Path, _: &std::fs::Metadata) -> impl PartialEq + use<> {
    std::fs::canonicalize(path).ok()
}
