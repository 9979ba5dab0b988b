//! Calls to the operating system that the standard library does not offer on every platform. No other module names an operating
//! system, and each function treats the other systems in its implementation; `cargo xtask tidy` enforces this.
//!
//! | | Linux | macOS and other Unix | Windows |
//! |---|---|---|---|
//! | pipes, devices and sockets are distinguished from files | yes | yes | a pipe is read if a person names it |
//! | a pipe in the place of a file blocks nothing | yes | yes | as a file |
//! | a file replaced by another is noticed | yes | yes | no |
//! | a changed file is noticed even if its times were set back | yes | yes | by its length and time alone |
//! | a program is ended with its descendants | yes, however often it forked | those still in its group | no |
//! | its memory is measured and limited | yes | no | no |
//! | sandbox around it | Landlock, namespaces, filter of system calls | none | none |
//! | growth of this process's memory is measured | yes | no | no |
//! | how it ended | signal or exit code | signal or exit code | exit code |
//! | a page is opened in a browser by | `xdg-open` | `open` | `explorer` |
//! | names of machine and processor | both | the machine's | both |
//!
//! Only the Linux column is tested during development.

mod browser;
mod call_filter;
mod enclosure;
mod file_kind;
mod file_stamp;
mod folder;
mod installed;
mod machine;
#[cfg(target_os = "linux")]
mod mounts;
mod plain_file;
mod process;
mod shortage;
mod signals;
mod sockets;
mod walls;

pub use browser::open_in_browser;
pub use call_filter::{filter_calls, has_call_filter};
pub use enclosure::{Restrictions, begin_session, restrict_self, status_of_shell, wait_for, wait_for_input};
pub use file_kind::{is_stream, kind_name, open_without_waiting};
pub use file_stamp::FileStamp;
pub use folder::{ProcessFolder, folder_bytes, remove_folder};
pub use installed::{installed_command, installed_program};
pub use machine::{machine_name, processor_name};
pub use plain_file::{FileIdentity, open_plain_file};
pub use process::{
    PeakMemory, ProcessMemory, adopt_orphans, beginning, children, close_to_others, ending, is_killed,
    kill_group, kill_process, memory, open_files, own_memory, own_sockets, reap, stop_process,
};
pub use shortage::is_shortage;
pub use signals::stop_signals;
pub use sockets::socket_paths;
pub use walls::{SHARED_MEMORY, can_have_namespaces, has_file_walls, write_only_in};
