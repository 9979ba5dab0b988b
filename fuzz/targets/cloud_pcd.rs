#![no_main]

cranny_fuzz::fuzz_reader!("cloud_pcd");
