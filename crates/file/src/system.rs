//! What is asked of the operating system beyond what the standard library offers on each. No other module names a system,
//! and each function says here, in its own body, what holds elsewhere; `cargo xtask tidy` keeps it so.
//!
//! | | Linux | macOS and other Unix | Windows |
//! |---|---|---|---|
//! | pipes, devices and sockets are told apart from files | yes | yes | a pipe is read where a person names it |
//! | a file that was changed is noticed, whatever its times were set to | yes | yes | by its length and time alone |
//! | a program is ended with all that it started | yes, however often it forked | what stayed in its group | it alone |
//! | its memory is seen, and limited | yes | no | no |
//! | walls around it | Landlock, namespaces | none | none |
//! | how it ended | signal or exit code | signal or exit code | exit code |
//! | names of machine and processor | both | the machine's | both |
//!
//! Only the first column is run by anybody who changes this.

mod file_kind;
mod file_stamp;
mod machine;
mod process;
mod walls;

pub use file_kind::{is_stream, kind_name};
pub use file_stamp::FileStamp;
pub use machine::{machine_name, processor_name};
pub use process::{
    ProcessMemory, adopt_orphans, beginning, children, close_to_others, ending, is_killed, kill_group,
    kill_process, lead_group, memory, reap,
};
pub use walls::{SHARED_MEMORY, can_have_namespaces, has_file_walls, shared_memory_bytes, write_only_in};
