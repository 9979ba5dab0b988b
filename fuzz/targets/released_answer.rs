#![no_main]

cranny_fuzz::fuzz_reader!(bench, "released_answer");
