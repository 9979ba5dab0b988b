//! The checker accepts what holds, and refuses each kind of change of it, at the line of the change.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use cranny_check::{check, sha256};

mod no_motion;

const SLIDE: &str = include_str!("certificates/slide.cert");

/// A mobile arm of 9 joints reaches a ball under a table, in straight edges and along rounded corners: written by a script from
/// the URDF, the scenario and a plan file, without Cranny.
const ARM: &str = include_str!("certificates/arm.cert");

/// Returns a certificate with other lines, and with the hash of its scene.
fn changed(from: &str, to: &str) -> String {
    assert!(SLIDE.contains(from), "{from}");
    let text = SLIDE.replacen(from, to, 1);
    with_hash(&text).unwrap()
}

fn with_hash(text: &str) -> Option<String> {
    let (format, scene) = text.split_once('\n')?;
    let (scene, rest) = scene.split_once("hash ")?;
    let (_, paths) = rest.split_once('\n')?;
    Some(format!("{format}\n{scene}hash {}\n{paths}", sha256(scene.as_bytes())))
}

fn reason(text: &str) -> String {
    check(text).expect_err("a certificate that does not hold").1
}

#[test]
fn the_hash_is_sha_256() {
    assert_eq!(sha256(b"abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    assert_eq!(sha256(b""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    assert_eq!(sha256(&[b'a'; 1000]), "41edece42d63e8d9bf515a9ba6932e1c20cbc9f5a5d134645adb5db1b9737ea3");
}

#[test]
fn a_certificate_that_holds_is_accepted() {
    let found = check(SLIDE).unwrap();
    assert_eq!(found[1..3], ["paths 1, of 1 pieces", "pairs 8, at least 0.00001 m apart but for `keep`"]);
    assert_eq!(found[3..5], ["keep cart floor 0.02", "skip cart arm adjacent-touching"]);
    assert!(found[5].starts_with("goal end 0.5 0 0 ") && found.len() == 6, "{found:?}");
}

#[test]
fn the_certificate_of_an_arm_is_accepted_and_not_for_a_greater_distance() {
    let found = check(ARM).unwrap();
    assert_eq!(found[1..3], ["paths 2, of 5 pieces", "pairs 88, at least 0.00001 m apart but for `keep`"]);
    let more = with_hash(&ARM.replacen("margin 1e-05", "margin 0.01", 1)).unwrap();
    assert!(reason(&more).contains("apart"));
}

#[test]
fn each_false_claim_is_refused() {
    for (from, to, expected) in [
        // Planes.
        ("p 0,1,0", "p 0,-1,0", "apart"),
        ("p 0,1,0", "p 1,0,0", "apart"),
        ("p =", "p 0,0,-1", "apart"),
        ("p 0,1,0", "p =", "no half-space"),
        ("p h 0,1,0 h ~ ~", "p h 1,0,0 ~", "apart"),
        // Cover.
        ("p h 0,1,0 h ~ ~", "p h 0,1,0 h ~", "mark"),
        ("p h 0,1,0 h ~ ~", "p h 0,1,0", "mark"),
        ("p h 0,0,1 ~", "p h 0,0,1 ~ ~", "marks"),
        ("p 0,-1,0", "p a 0,-1,0 ~", "halved"),
        // Pairs.
        ("p 0,-1,0\n", "", "cart, wedge: the plane does not keep"),
        ("p h 0,-1,0 ~\n", "", "`p` is missing"),
        ("p 0,1,0\np =\n", "p =\np 0,1,0\n", "no half-space"),
        ("skip 1 2 adjacent-touching\n", "", "missing"),
        // Other scenes.
        ("box 0 0.9 0 1 0 0 0 2 0.1 1", "box 0 0.35 0 1 0 0 0 2 0.1 1", "apart"),
        ("half 0 0 -0.15 1 0 0 0", "half 0 0 -0.11 1 0 0 0", "apart"),
        ("keep 1 4 0.02", "keep 1 4 0.06", "apart"),
        ("margin 0.00001", "margin 0.5", "apart"),
        ("ball 0 0 0 1 0 0 0 0.1", "ball 0 0 0 1 0 0 0 0.2", "apart"),
        // Ends and limits.
        ("start -0.5 0", "start -0.5 0.001", "begin"),
        ("goal end 0.5 0 0", "goal end 0.502 0 0", "goal"),
        ("goal end 0.5 0 0 0.96", "goal end 0.5 0 0 0.90", "goal"),
        ("joint turn -3 3", "joint turn -3 0.4", "limits"),
        // Meshes.
        ("p 0,-1,0", "p b 0,-1,0 ~", "inside"),
    ] {
        let found = reason(&changed(from, to));
        assert!(found.contains(expected), "{from} -> {to}: {found}");
    }
    let other = SLIDE.replacen("half 0 0 -0.15", "half 0 0 -0.16", 1);
    assert!(reason(&other).contains("hash"));
}

#[test]
fn malformed_lines_are_refused_with_their_number() {
    for (from, to) in [
        ("cranny-certificate/1", "cranny-certificate/2"),
        ("joint slide -1 1", "joint slide -1"),
        ("joint slide -1 1", "joint slide NaN 1"),
        ("joint slide -1 1", "joint slide -inf 1"),
        ("link cart 0", "link cart 1"),
        ("link cart 0", "link cart -"),
        ("slide 0 1 0 1 0 0", "slide 2 1 0 1 0 0"),
        ("slide 0 1 0 1 0 0", "slide 0 1 0 0 0 0"),
        ("ball 0 0 0 1 0 0 0 0.1", "ball 0 0 0 0 0 0 0 0.1"),
        ("ball 0 0 0 1 0 0 0 0.1", "ball 0 0 0 1 0 0 0 -0.1"),
        ("ball 0 0 0 1 0 0 0 0.1", "half 0 0 0 1 0 0 0"),
        ("f 1 2 3", "f 1 2 4"),
        ("margin 0.00001", "margin -0.1"),
        ("skip 1 2 adjacent-touching", "skip 2 1 adjacent-touching"),
        ("skip 1 2 adjacent-touching", "skip 1 99999999999999999999 x"),
        ("tip 2", "tip 3"),
        ("q 0.5 0.5", "q 0.5"),
        ("q 0.5 0.5", "q 0.5 1e400"),
        ("p 0,1,0", "p 0,1"),
        ("p 0,1,0", "p 0,0,0"),
        ("p 0,1,0", "p 0,1,70000"),
        ("p 0,1,0", "p "),
        ("p 0,1,0", "p ~"),
        ("end\n", ""),
        ("end\n", "end"),
        ("end\n", "end\nend\n"),
        ("end\n", "end\nend"),
    ] {
        assert!(check(&changed(from, to)).is_err(), "{from} -> {to}");
    }
}

/// A second scene starts where the first one ends, and what differs is named.
#[test]
fn scenes_follow_each_other() {
    let (first, _) = SLIDE.split_once("end\n").unwrap();
    let back = SLIDE
        .replace("start -0.5 0", "start 0.5 0.5")
        .replace("q -0.5 0\nq 0.5 0.5", "q 0.5 0.5\nq 0.5 0.49");
    let back = with_hash(&back.replace("body floor", "body ground")).unwrap();
    let (_, second) = back.split_once('\n').unwrap();
    let found = check(&format!("{first}{second}")).unwrap();
    assert_eq!(found[9..11], ["keep cart ground 0.02", "skip cart arm adjacent-touching"]);
    assert_eq!(found[12..], ["- body floor", "+ body ground"]);
    let elsewhere = with_hash(&back.replace("start 0.5 0.5", "start 0.500001 0.5")).unwrap();
    let (_, second) = elsewhere.split_once('\n').unwrap();
    assert!(reason(&format!("{first}{second}")).contains("does not start"));
}

/// A line `= FROM COUNT` stands for lines before it, so that the scene has the same hash, for both checkers.
#[test]
fn repeated_lines_stand_for_those_before() {
    let (first, _) = SLIDE.split_once("end\n").unwrap();
    let back = SLIDE
        .replace("start -0.5 0", "start 0.5 0.5")
        .replace("q -0.5 0\nq 0.5 0.5", "q 0.5 0.5\nq 0.5 0.49");
    let back = with_hash(&back).unwrap();
    let (_, second) = back.split_once('\n').unwrap();
    let whole = format!("{first}{second}");
    let bodies = SLIDE.lines().position(|line| line.starts_with("body")).unwrap();
    // The first line of the second scene is that of the first one, and so are those of its joints and links.
    let (format, count) = ("cranny-certificate/1\n", bodies - 1);
    let links: String = SLIDE.split_inclusive('\n').skip(1).take(count).collect();
    let with = |repeat: &str| {
        format!(
            "{format}{}",
            whole[format.len()..]
                .replacen(&links, "\0", 2)
                .replacen('\0', &links, 1)
                .replacen('\0', repeat, 1)
        )
    };
    let expected = check(&whole).unwrap();
    let half = count / 2;
    let line = first.lines().count() + 1;
    for (holds, text) in [
        (true, with(&format!("= 2 {count}\n"))),
        (true, with(&format!("= 2 {half}\n= {} {}\n", 2 + half, count - half))),
        (false, with(&format!("= 2 {}\n", count - 1))),
        (false, with(&format!("= 3 {count}\n"))),
        (false, with(&format!("= 02 {count}\n"))),
        (false, with(&format!("= 2 {count} 1\n"))),
        (false, with("= 2\n")),
        (false, with("= 0 1\n")),
        (false, with("= 2 0\n")),
        (false, with(&format!("= {line} 1\n"))),
        (false, with(&format!("= 2 {half}\n= {line} 1\n"))),
        (false, with("= 2 99999999999999999999\n")),
        (false, with(&format!("= 2 {count}"))),
    ] {
        let found = check(&text);
        assert_eq!(found.is_ok(), holds, "{found:?}");
        found.iter().for_each(|found| assert_eq!(found, &expected));
        if let Some((code, texts)) = python("repeated.cert", &text, None, true) {
            assert_eq!(code, Some(i32::from(!holds)), "{texts:?}");
        }
    }
    // Gigabytes in a few lines.
    let point = format!("v {0} {0} {0}\n", format!("0.{}", "1".repeat(28)));
    let heap = format!(
        "body heap\nhull 0 0 0 1 0 0 0 0\n{}{}body floor",
        point.repeat(900),
        "= 15 900\n".repeat(20_000)
    );
    let text = changed("body floor", &heap);
    assert!(reason(&text).contains("more text"));
    if let Some((_, [answer, _])) = python("heap.cert", &text, None, true) {
        assert!(answer.contains("more text"), "{answer}");
    }
}

/// A scene of a robot with two turning links, of which one, by its number, is the parent of the hand.
fn scene(links: [&str; 2], limits: &str, [of_hand, tip]: [u8; 2], hand: &str) -> String {
    let at = "1 0 0 0";
    let turning = |name: &str| {
        let z = if name == "high" { 5 } else { 0 };
        format!("link {name} 0 0 0 {z} {at} turn 0 1 0 0 0 1\n")
    };
    let z = if links[usize::from(of_hand) - 1] == "high" { 5 } else { 0 };
    let scene = format!(
        "scene it\njoint j {limits}\nlink root - 0 0 0 {at} fixed\n{}{}link hand {of_hand} 0 0 0 {at} fixed\n\
         box 0 0 0 {at} {hand}\nbody block\nbox 3 0 0 {at} 0.5 0.5 9\nmargin 0\nstart 0\ntip {tip}\n\
         goal it 0 0 {z} {at}\n",
        turning(links[0]),
        turning(links[1])
    );
    let proof = "path way\npiece\nq 0\nq 0\np 1,0,0\n";
    format!("{scene}hash {}\n{proof}", sha256(scene.as_bytes()))
}

/// Between two scenes the arm stands still, so that it must be the same arm: its lines name parents by numbers, which stand for
/// other links in another order.
#[test]
fn the_robot_is_the_same_in_all_scenes() {
    let after = |second: &str| {
        let first = scene(["high", "low"], "-1 1", [1, 3], "0.1 0.1 0.1");
        check(&format!("cranny-certificate/1\n{first}{second}end\n"))
    };
    let refused = |second: &str, expected: &str| {
        let (_, reason) = after(second).expect_err("another robot");
        assert!(reason.contains(expected), "{reason}");
    };
    // The same, also if links have other numbers.
    for second in [
        scene(["high", "low"], "-1 1", [1, 3], "0.1 0.1 0.1"),
        scene(["low", "high"], "-1 1", [2, 3], "0.1 0.1 0.1"),
    ] {
        let found = after(&second).unwrap();
        assert!(!found.iter().any(|line| line.starts_with(['-', '+'])), "{found:?}");
    }
    refused(&scene(["low", "high"], "-1 1", [1, 3], "0.1 0.1 0.1"), "down to the tip");
    refused(&scene(["high", "low"], "-9 9", [1, 3], "0.1 0.1 0.1"), "joints");
    refused(&scene(["high", "low"], "-1 1", [1, 1], "0.1 0.1 0.1"), "down to the tip");
    refused(&scene(["high", "low"], "-1 1", [1, 3], "0.1 0.1 0.2"), "down to the tip");
    // With the tip above the hand, the hand may change, and the other turning link may not.
    let of_high = |hand: &str, low: &str| {
        let text = scene(["high", "low"], "-1 1", [1, 1], hand).replace("link low", low);
        with_hash(&format!("cranny-certificate/1\n{text}")).unwrap().replace("cranny-certificate/1\n", "")
    };
    let first = of_high("0.1 0.1 0.1", "link low");
    let follow = |second: &str| check(&format!("cranny-certificate/1\n{first}{second}end\n"));
    let found = follow(&of_high("0.1 0.1 0.2", "link low")).unwrap();
    let hand = "link hand high 0 0 0 1 0 0 0 fixed";
    assert_eq!(found[found.len() - 2..], [format!("- {hand}"), format!("+ {hand}")]);
    let (_, reason) = follow(&of_high("0.1 0.1 0.1", "link deep")).expect_err("another link");
    assert!(reason.contains("moved against the tip"), "{reason}");
}

/// Nesting and counts that a file states cost nothing.
#[test]
fn hostile_trees_end() {
    let deep = format!("p {}0,1,0", "h ".repeat(100_000));
    assert!(reason(&changed("p 0,1,0", &deep)).contains("halvings"));
    let many = format!("p {}", "0,1,0 ".repeat(100_000));
    assert!(reason(&changed("p 0,1,0", &many)).contains("marks"));
}

/// Random damage is refused or harmless, and never a crash.
#[test]
fn damaged_bytes_never_panic() {
    let mut state = 7_u64;
    let mut next = |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below as u64) as usize
    };
    let words = ["NaN", "1e999", "-1", "h", "a", "b", "~", "=", "99999999", "0", "\n", " ", "mesh", "f", "é"];
    for _ in 0..20_000 {
        let mut text = SLIDE.to_owned();
        for _ in 0..=next(3) {
            let places: Vec<usize> = text.char_indices().map(|(at, _)| at).collect();
            let (from, to) = (places[next(places.len())], places[next(places.len())]);
            match next(3) {
                0 => text.insert_str(from, words[next(words.len())]),
                1 => text.replace_range(from..text.len().min(from + 1), words[next(words.len())]),
                _ if from < to && to - from < 40 => text.replace_range(from..to, ""),
                _ => {}
            }
        }
        let _ = check(&text);
        let _ = with_hash(&text).map(|text| check(&text));
    }
}

/// Bounds of a direction and of points of a link, each with its proof in a piece.
#[test]
fn bounds_are_checked() {
    let bounded = |line: &str, proof: &str| {
        let text = SLIDE.replacen("start -0.5 0", &format!("{line}\nstart -0.5 0"), 1);
        with_hash(&text.replacen("end\n", &format!("{proof}end\n"), 1)).unwrap()
    };
    // The arm turns by 0.5 rad about z, and slides from x = -0.5 to 0.5.
    let turns = |angle: f64| bounded(&format!("cone level 2 1 0 0 1 0 0 {angle}"), "b h . .\n");
    assert!(reason(&turns(0.49)).contains("bound"));
    let found = check(&turns(0.52)).unwrap();
    assert_eq!(found[5], "cone level arm 1 0 0 1 0 0 0.52");
    let upright = bounded("cone level 2 0 0 1 0 0 1 0.001", "b .\n");
    check(&bounded("cone level 2 0 0 1 0 0 1 0.6", "b .\n")).unwrap();
    assert!(reason(&upright).contains("bound"));
    let near = |radius: f64| bounded(&format!("near wrist 2 0 0 0 0 0 0 {radius}"), "b .\n");
    assert!(reason(&near(0.499)).contains("bound"));
    check(&near(0.501)).unwrap();
    let inside = |half: f64| bounded(&format!("inside wrist 2 0 0 0 0 0 0 1 0 0 0 {half} 1 1"), "b .\n");
    assert!(reason(&inside(0.499)).contains("bound"));
    check(&inside(0.501)).unwrap();
    // Proofs that are missing, of another bound, or too short.
    for proof in ["", "b 0 .\n", "b h .\n", "b . .\n", "b ~\n"] {
        assert!(check(&bounded("near wrist 2 0 0 0 0 0 0 1", proof)).is_err(), "{proof}");
    }
}

/// Runs the checker in Python on a certificate, or on nothing but an option, with a reader of its answer or without one.
/// Returns its exit code, its answer and its complaints; `None` without Python.
fn python(name: &str, text: &str, option: Option<&str>, is_read: bool) -> Option<(Option<i32>, [String; 2])> {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&file, text).unwrap();
    let mut command = Command::new("python3");
    command.arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("check.py"));
    command.arg(option.map_or(file, PathBuf::from)).stdout(Stdio::piped()).stderr(Stdio::piped());
    let Ok(mut child) = command.spawn() else {
        eprintln!("SKIPPED: the checker in Python (no python3)");
        return None;
    };
    if !is_read {
        drop(child.stdout.take());
    }
    let output = child.wait_with_output().unwrap();
    let texts = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    Some((output.status.code(), texts))
}

/// Rules of the format at their limits: both checkers accept a certificate, or both refuse it.
#[test]
fn both_checkers_agree_at_the_limits() {
    let cone = |angle: &str, proof: &str| {
        let text = changed("start -0.5 0", &format!("cone level 2 1 0 0 1 0 0 {angle}\nstart -0.5 0"));
        text.replacen("\nend\n", &format!("\n{proof}\nend\n"), 1)
    };
    let halved = |count: usize| {
        let marks = format!("p {}0,0,1{}", "h ".repeat(count), " ~".repeat(count));
        changed("p 0,0,1", &marks)
    };
    let of_points = |count: usize| {
        let share = |i: usize| i as f64 / (count - 1) as f64;
        let points: Vec<String> =
            (0..count).map(|i| format!("q {} {}", share(i) - 0.5, 0.5 * share(i))).collect();
        changed("q -0.5 0\nq 0.5 0.5", &points.join("\n"))
    };
    let reason = |reason: &str| changed("1 2 adjacent-touching", &format!("1 2 {reason}"));
    let axis = |z: &str| changed("turn 1 1 0 0 0 1", &format!("turn 1 1 0 0 0 {z}"));
    let quaternion = |w: &str| changed("box 0 0.9 0 1 0", &format!("box 0 0.9 0 {w} 0"));
    let cases = [
        (true, cone("3.1", "b .")),
        (false, cone("3.1000000000000005", "b .")),
        // Whole numbers have one form each.
        (false, cone("3", "b 0 .")),
        (false, changed("tip 2", "tip 02")),
        (false, changed("p 0,0,1", "p 0,0,000001")),
        (false, changed("p 0,0,1", "p 0,-0,1")),
        (false, changed("p 0,0,1", "p 0,0,+1")),
        // Values of joints.
        (true, changed("joint turn -3 3", "joint turn -3 1000000")),
        (false, changed("turn 1 1 0 0 0 1", "turn 1 1 999998 0 0 1")),
        (false, changed("slide 0 1 0 1 0 0", "slide 0 1 -999999.5 1 0 0")),
        // Directions and quaternions.
        (true, axis("0.001")),
        (false, axis("0.00099999999999999")),
        (true, axis("1000")),
        (false, axis("1000.0000000000002")),
        (true, quaternion("0.001")),
        (false, quaternion("0.0009 0.0009")),
        (false, quaternion("1001")),
        // Words.
        (true, reason("!~")),
        (false, reason("\x1b[2K\x1b[1A")),
        (false, reason("a\x7f")),
        (false, reason("a\rb")),
        (false, reason("a\u{a0}b")),
        (false, reason("a\u{202e}b")),
        (false, reason("größer")),
        (false, changed("body wedge", "body wall")),
        (false, changed("body wedge", "body cart")),
        // Counts.
        (true, of_points(100)),
        (false, of_points(101)),
        (true, halved(96)),
        (false, halved(97)),
        (false, SLIDE.to_owned() + "more"),
    ];
    for (holds, text) in cases {
        let found = check(&text);
        assert_eq!(found.is_ok(), holds, "{found:?}\n{text}");
        if let Some((code, texts)) = python("limits.cert", &text, None, true) {
            assert_eq!(code, Some(i32::from(!holds)), "{texts:?}\n{text}");
        }
    }
}

/// A cloud of 2000 balls, in a proof that halves it into 64 parts, is not too much work.
#[test]
fn clouds_are_checked_by_both() {
    fn halved(depth: u32) -> String {
        if depth == 0 { " ~".to_owned() } else { format!(" b{}", halved(depth - 1).repeat(2)) }
    }
    let balls: Vec<String> =
        (0..2000).map(|i| format!("ball {} 0.9 0 1 0 0 0 0.05", f64::from(i) / 1000.0 - 1.0)).collect();
    let text = changed("box 0 0.9 0 1 0 0 0 2 0.1 1", &balls.join("\n"));
    let text = text.replacen("p 0,1,0", &format!("p{}", halved(6).replacen('~', "0,1,0", 1)), 1);
    check(&text).unwrap();
    if let Some((code, texts)) = python("cloud.cert", &text, None, true) {
        assert_eq!(code, Some(0), "{texts:?}");
    }
}

#[test]
fn both_programs_have_a_usage_and_need_no_reader() {
    for option in ["-h", "--help"] {
        let output = Command::new(env!("CARGO_BIN_EXE_cranny-check")).arg(option).output().unwrap();
        assert!(output.status.success() && output.stdout.starts_with(b"usage: "), "{output:?}");
        if let Some((code, [answer, complaints])) = python("usage.cert", "", Some(option), true) {
            assert!(code == Some(0) && answer.starts_with("usage: ") && complaints.is_empty());
        }
    }
    for (text, expected) in [(SLIDE, 0), ("", 1)] {
        if let Some((code, texts)) = python("unread.cert", text, None, false) {
            assert_eq!((code, &texts[1][..]), (Some(expected), ""));
        }
    }
}
