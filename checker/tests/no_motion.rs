//! Certificates that no motion exists.

use cranny_check::check;

use super::{python, with_hash};

/// A cart with an arm of 0.2 m stands before a wall, and the goal is behind it.
const WALL: &str = "cranny-certificate/1
scene wall
joint x -1 1
joint turn -3 3
link base - 0 0 0 1 0 0 0 fixed
link cart 0 0 0 0 1 0 0 0 slide 0 1 0 1 0 0
box 0 0 0 1 0 0 0 0.1 0.1 0.1
link arm 1 0 0 0 1 0 0 0 turn 1 1 0 0 0 1
link hand 2 0.2 0 0 1 0 0 0 fixed
body wall
box 0.5 0 0 1 0 0 0 0.05 1 1
margin 0
start -0.5 0
tip 3
goal end 0.9 0 0 1 0 0 0
hash -
none 2
boxes s0 . s0 s0 . s0 . 4,0,1,0,0.46,0,0 .
end
";

/// Boxes of joint values show, to both checkers, that no motion exists, and nothing else does.
#[test]
fn that_no_motion_exists_is_checked() {
    let found = check(&with_hash(WALL).unwrap()).unwrap();
    assert_eq!(
        found[1..],
        [
            "no motion leads to a goal: 3 of 4 boxes are left to the start",
            "goals 1, of which 0 are blocked",
            "pairs 1, at least 0 m apart but for `keep`",
            "goal end 0.9 0 0 1 0 0 0"
        ]
    );
    let box_of_cart = "box 0 0 0 1 0 0 0 0.1 0.1 0.1";
    let mark = "4,0,1,0,0.46,0,0";
    for (holds, from, to) in [
        // The reach may count from any link that only the slide moves, and the point may be of either object.
        (true, "none 2", "none 1 0"),
        (true, mark, "s0 1,0,4,0,0.08,0.01,0 4,0,1,0,0.46,0,0"),
        (true, box_of_cart, "cylinder 0 0 0 0.7071067811865476 0 0.7071067811865476 0 0.1 0.1"),
        (true, box_of_cart, "ball 0 0 0 1 0 0 0 0.1"),
        (true, box_of_cart, "capsule 0 0 0 0.7071067811865476 0 0.7071067811865476 0 0.05 0.06"),
        (true, "box 0.5 0 0 1 0 0 0 0.05 1 1", "half 0.55 0 0 0.7071067811865476 0 0.7071067811865476 0"),
        // What is not excluded.
        (false, mark, "1,0,4,0,0.08,0.01,0"),
        (false, mark, "."),
        (false, mark, "4,0,1,0,0.44,0,0"),
        (false, mark, "4,0,1,0,0.48,0,0"),
        (false, mark, "4,0,1,0,0.46,0,0.11"),
        (false, "s0 . 4,0", "s1 . 4,0"),
        (false, box_of_cart, "box 0 0 0 1 0 0 0 0.03 0.1 0.1"),
        (false, "box 0.5 0 0 1 0 0 0 0.05 1 1", "hull 0.5 0 0 1 0 0 0 1\nv 0 0 0"),
        // Pairs that may touch, or are none.
        (false, "margin 0\n", "margin 0\nskip 1 4 declared\n"),
        (false, "margin 0\n", "margin 0\nkeep 1 4 -0.001\n"),
        (false, mark, "4,0,4,0,0.46,0,0"),
        (false, mark, "4,1,1,0,0.46,0,0"),
        // What is in reach.
        (false, "goal end 0.9", "goal end 0.57"),
        (false, "start -0.5 0", "start 0.7 0"),
        (false, "hand 2 0.2 0 0", "hand 2 0.6 0 0"),
        (false, "none 2", "none 1 0.6"),
        (false, "none 2", "none 1"),
        (false, "none 2", "none 2 0"),
        (false, "none 2", "none 4"),
        // The tree, and the file.
        (false, mark, &format!("{mark} .")),
        (false, "s0 . s0", "s2 . s0"),
        (false, "s0 . s0", "s00 . s0"),
        (false, mark, "4,0,1,0,0.46,0"),
        (false, mark, "4,0,1,0,0.46,0,NaN"),
        (false, "end\n", "path way\npiece\nq 0 0\nq 0 0\nend\n"),
        (
            false,
            "end\n",
            &format!("{}end\n", WALL.split_inclusive('\n').skip(1).take(18).collect::<String>()),
        ),
    ] {
        assert_holds(WALL, (from, to), holds);
    }
}

/// Replaces some words of a certificate: then it holds for both checkers, or for none.
fn assert_holds(certificate: &str, (from, to): (&str, &str), holds: bool) {
    assert!(certificate.contains(from), "{from}");
    let text = with_hash(&certificate.replacen(from, to, 1)).unwrap();
    let found = check(&text);
    assert_eq!(found.is_ok(), holds, "{from} -> {to}: {found:?}");
    // Tests run beside each other.
    let file = if certificate.contains("blocked") { "blocked.cert" } else { "wall.cert" };
    if let Some((code, texts)) = python(file, &text, None, true) {
        assert_eq!(code, Some(i32::from(!holds)), "{from} -> {to}: {texts:?}");
    }
}

/// A goal at which the hand is in the world, by more than the tolerance of goals, is no end of a motion.
#[test]
fn goals_are_blocked() {
    let hand = "fixed\nbox 0 0 0 1 0 0 0 0.02 0.02 0.02\nbody";
    let inside = WALL
        .replace("fixed\nbody", hand)
        .replace("goal end 0.9", "goal end 0.44")
        .replace("boxes s0 . s0 s0 . s0 . 4,0,1,0,0.46,0,0 .", "boxes .\nblocked 0 3,0,4,0,0.018,0,0");
    let mark = "3,0,4,0,0.018,0,0";
    let own = "box 0 0 0 1 0 0 0 0.02 0.02 0.02";
    for (holds, from, to) in [
        (true, "end\n", "end\n"),
        (true, own, "ball 0 0 0 1 0 0 0 0.02"),
        (true, own, "capsule 0 0 0 0.7071067811865476 0 0.7071067811865476 0 0.01 0.01"),
        (true, own, "cylinder 0 0 0 0.7071067811865476 0 0.7071067811865476 0 0.02 0.02"),
        (true, own, "cylinder 0 0 0 1 0 0 0 0.02 0.02"),
        (true, mark, "3,0,4,0,0.0186,0,0"),
        // 1 mm, and 0.02 m · 2 sin ½°.
        (false, mark, "3,0,4,0,0.0187,0,0"),
        (false, own, "ball 0 0 0 1 0 0 0 0.0193"),
        (false, own, "cylinder 0 0 0 1 0 0 0 0.02 0.0193"),
        (false, own, "cylinder 0 0 0 0.7071067811865476 0 0.7071067811865476 0 0.0193 0.02"),
        // The world is elsewhere, or the goal.
        (false, mark, "3,0,4,0,0.009,0,0"),
        (false, "goal end 0.44", "goal end 0.43"),
        (false, "blocked 0", "blocked 1"),
        (false, "goal end 0.44 0 0 1 0 0 0", "goal end 0.44 0 0 1 0 0 0\ngoal other 0.2 0 0 1 0 0 0"),
        (false, &format!("blocked 0 {mark}\n"), ""),
        // A joint moves the object against the tip, or the other one; and pairs that may touch.
        (false, mark, "1,0,4,0,0.09,0,0"),
        (false, mark, "4,0,3,0,0,0,0"),
        (false, mark, "3,0,1,0,0,0,0"),
        (false, "margin 0\n", "margin 0\nskip 3 4 declared\n"),
        (false, "margin 0\n", "margin 0\nkeep 3 4 -0.001\n"),
        // Marks.
        (false, mark, "3,0,4,0,v0"),
        (false, mark, "3,0,4,0"),
        (false, mark, &format!("{mark} {mark}")),
        // A point of a hull is none that is known to be inside.
        (false, own, "hull 0 0 0 1 0 0 0 0.02\nv 0 0 0"),
    ] {
        assert_holds(&inside, (from, to), holds);
    }
    // A vertex that no face has is no point of a mesh.
    let mesh = "mesh 0 0 0 1 0 0 0\nv 0.018 0 0\nv 0 0 0\nv 0 0.01 0\nv 0 0 0.01\nf 1 2 3";
    let mesh = inside.replace(own, mesh).replace(mark, "3,0,4,0,v0");
    assert_holds(&mesh, ("end\n", "end\n"), false);
    assert_holds(&mesh, ("f 1 2 3", "f 1 2 0"), true);
    // A vertex is in its solid, and the ball around it in the wall.
    for solid in
        ["hull 0 0 0 1 0 0 0 0\nv 0 0 0\nv 0.018 0 0", "mesh 0 0 0 1 0 0 0\nv 0 0 0\nv 0.018 0 0\nf 0 1 0"]
    {
        let hull = inside.replace(own, solid).replace(mark, "3,0,4,0,v1");
        for (holds, from, to) in [
            (true, "end\n", "end\n"),
            (true, "0.018", "0.0115"),
            (false, "0.018", "0.0111"),
            (false, "v1", "v0"),
            (false, "v1", "v2"),
            (false, "v1", "v01"),
            (false, "v1", "v"),
            (false, "body wall\nbox 0.5", "body wall\nbox 0.51"),
        ] {
            assert_holds(&hull, (from, to), holds);
        }
    }
}

/// A point of a link that a joint turns excludes nothing, because the checkers enclose its pose in different ways.
#[test]
fn no_joint_turns_what_excludes_a_box() {
    let text = WALL.replace("link hand", "ball 0 0 0 1 0 0 0 0.1\nlink hand").replace("4,0,1,0,", "4,0,2,0,");
    let text = with_hash(&text).unwrap();
    assert!(check(&text).unwrap_err().1.contains("only slides"));
    if let Some((code, [answer, _])) = python("turned.cert", &text, None, true) {
        assert!(code == Some(1) && answer.contains("only slides"), "{answer}");
    }
}

/// Returns a tree of this depth, all boxes of which are open.
fn open_tree(depth: u32) -> String {
    if depth == 0 { ".".to_owned() } else { format!("s0 {0} {0}", open_tree(depth - 1)) }
}

/// Boxes by the thousand are searched at once, and millions are refused.
#[test]
fn many_boxes_are_searched_or_refused() {
    let reason = |depth: u32| {
        let text = WALL.replace("s0 . s0 s0 . s0 . 4,0,1,0,0.46,0,0 .", &open_tree(depth));
        check(&with_hash(&text).unwrap()).unwrap_err().1
    };
    assert_eq!(reason(12), "a goal may be within reach");
    assert!(reason(21).contains("more boxes"));
}
