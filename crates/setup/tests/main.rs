//! What is found out about robots from their URDFs.

mod built_in;
