#![no_main]

cranny_fuzz::fuzz_reader!("released_answer");
