#![no_main]

cranny_fuzz::fuzz_reader!("grasps_npy");
