//! Forward kinematics singly and in lanes, and attempts of inverse kinematics, of the built-in robot.

use std::hint::black_box;
use std::path::Path;
use std::time::Duration;

use cranny_robot::{IK_BATCH, IkBatch, IkSettings, LaneFrame, LaneKinematics, Robot, RobotOptions};
use cranny_spatial::{LANES, LaneArray, Pose, Stream};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use fearless_simd::{Level, dispatch};

fn robot() -> Robot {
    let urdf =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenario/robots/panda_mobile/panda_mobile.urdf");
    let options = RobotOptions {
        tip: Some("panda_grasptarget".to_owned()),
        fixed: ["panda_finger_joint1", "panda_finger_joint2"].map(|joint| (joint.to_owned(), 0.04)).into(),
        ..RobotOptions::default()
    };
    Robot::load(&urdf, &options).expect("the built-in robot")
}

fn forward(criterion: &mut Criterion) {
    let (robot, mut random) = (robot(), Stream::new(0, 0));
    let mut group = criterion.benchmark_group("forward kinematics");
    group.throughput(Throughput::Elements(LANES as u64));

    let configurations: Vec<Vec<f64>> = (0..LANES).map(|_| robot.random_configuration(&mut random)).collect();
    let mut frames = robot.frames();
    group.bench_function("16 configurations one at a time", |bencher| {
        bencher.iter(|| {
            for q in &configurations {
                robot.forward_kinematics(black_box(q), &mut frames);
                black_box(&frames);
            }
        });
    });

    #[allow(clippy::cast_possible_truncation, reason = "lanes are `f32` by design")]
    let rows: Vec<LaneArray> = (0..robot.dof())
        .map(|joint| std::array::from_fn(|lane| configurations[lane][joint] as f32))
        .collect();
    let kinematics = LaneKinematics::new(&robot);
    let mut lane_frames = vec![LaneFrame::IDENTITY; kinematics.frame_count()];
    group.bench_function("16 configurations in lanes", |bencher| {
        bencher.iter(|| {
            let rows = black_box(&rows);
            dispatch!(Level::new(), simd => kinematics.forward(simd, rows, &[], &mut lane_frames));
            black_box(&lane_frames);
        });
    });
}

fn inverse(criterion: &mut Criterion) {
    let (robot, mut random) = (robot(), Stream::new(1, 0));
    let mut frames = robot.frames();
    let mut pose = |random: &mut Stream| -> Pose {
        robot.forward_kinematics(&robot.random_configuration(random), &mut frames);
        *frames.link(robot.tip())
    };
    let poses: Vec<Pose> = (0..64).map(|_| pose(&mut random)).collect();
    let mut batch = IkBatch::new(&robot, IkSettings::default());
    let mut next = poses.iter().cycle();
    let mut group = criterion.benchmark_group("inverse kinematics");
    group.throughput(Throughput::Elements(IK_BATCH as u64));
    group.bench_function("16 attempts in a batch, to poses within reach", |bencher| {
        bencher.iter(|| {
            for (attempt, pose) in (0..IK_BATCH).zip(&mut next) {
                batch.draw(attempt, pose, &mut random);
            }
            batch.run(IK_BATCH);
            (0..IK_BATCH).filter(|attempt| batch.solution(*attempt).is_some()).count()
        });
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(2));
    targets = forward, inverse
}
criterion_main!(benches);
