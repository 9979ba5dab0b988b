#![no_main]

cranny_fuzz::fuzz_reader!("depth_image");
