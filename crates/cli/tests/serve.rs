//! `cranny serve`: MoveIt's requests over HTTP get proven responses, bad ones a reason, strangers nothing.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

const JOINTS: [&str; 7] =
    ["fr3_joint1", "fr3_joint2", "fr3_joint3", "fr3_joint4", "fr3_joint5", "fr3_joint6", "fr3_joint7"];
const START: [f64; 7] = [0.0, -0.8, 0.0, -2.4, 0.0, 1.6, 0.8];

/// Running `cranny serve` that has printed its address.
struct Server {
    child: Child,
    host: String,
    token: String,
}

impl Server {
    fn start(arguments: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_cranny"))
            .args(["serve", "--robot", "fr3"])
            .args(arguments)
            .stdout(Stdio::piped())
            .spawn()
            .expect("it runs");
        let mut line = String::new();
        BufReader::new(child.stdout.take().expect("a pipe")).read_line(&mut line).expect("a line");
        let address = line.split(' ').next().and_then(|url| url.strip_prefix("http://")).expect("an address");
        let (host, token) = address.trim_end_matches('/').split_once('/').expect("a token");
        Self { child, host: host.to_owned(), token: token.to_owned() }
    }

    fn send(&self, method: &str, path: &str, content: &str) -> TcpStream {
        let mut stream = TcpStream::connect(&self.host).expect("it listens");
        let head = format!(
            "{method} {path} HTTP/1.1\r\nHost: {}\r\nContent-Length: {}\r\n\r\n",
            self.host,
            content.len()
        );
        // A refused request need not be read to its end.
        let _ = stream.write_all((head + content).as_bytes());
        stream
    }

    /// Returns status and content of the reply to a request below the token.
    fn reply(&self, method: &str, path: &str, content: &str) -> (u16, Value) {
        received(self.send(method, &format!("/{}{path}", self.token), content))
    }

    fn plan(&self, document: &Value) -> (u16, Value) {
        self.reply("POST", "/plan", &document.to_string())
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn received(mut stream: TcpStream) -> (u16, Value) {
    let mut reply = String::new();
    stream.read_to_string(&mut reply).expect("it answers");
    let (head, content) = reply.split_once("\r\n\r\n").expect("a head and a content");
    let status = head.split(' ').nth(1).and_then(|status| status.parse().ok()).expect("a status");
    (status, serde_json::from_str(content).unwrap_or_else(|_| content.into()))
}

/// Returns a request to turn the first joint to `turn`, with a box of these side lengths (m) at `position`.
fn request(turn: f64, position: [f64; 3], size: [f64; 3]) -> Value {
    let mut goal = START;
    goal[0] = turn;
    let of_joint = |(joint, position)| json!({"joint_name": joint, "position": position});
    let constraints: Vec<Value> = JOINTS.iter().zip(goal).map(of_joint).collect();
    json!({
        "planning_scene": {"name": "cell", "robot_model_name": "fr3", "world": {"collision_objects": [{
            "id": "crate",
            "header": {"frame_id": "fr3_link0"},
            "pose": {"position": {"x": position[0], "y": position[1], "z": position[2]},
                     "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}},
            "primitives": [{"type": 1, "dimensions": size}],
            "primitive_poses": [{"position": {"x": 0.0, "y": 0.0, "z": 0.0},
                                 "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}],
            "operation": 0,
        }]}},
        "motion_plan_request": {
            "group_name": "arm",
            "start_state": {"joint_state": {"name": JOINTS, "position": START}},
            "goal_constraints": [{"joint_constraints": constraints}],
            "allowed_planning_time": 5.0,
        },
    })
}

/// A crate in the way of the shortest path.
const BETWEEN: [[f64; 3]; 2] = [[0.5, 0.25, 0.45], [0.1, 0.1, 0.3]];

#[test]
fn a_request_gets_a_timed_motion_and_its_proof() {
    let server = Server::start(&["--margin", "2", "--rate", "50"]);
    let (status, about) = server.reply("GET", "/", "");
    assert_eq!((status, &about["name"], &about["robot"]), (200, &json!("cranny"), &json!("fr3")));
    assert!(about["groups"].as_array().expect("groups").contains(&json!("arm")), "{about}");

    let document = request(1.2, BETWEEN[0], BETWEEN[1]);
    let (status, answer) = server.plan(&document);
    assert_eq!(status, 200, "{answer}");
    let (response, proof) = (&answer["motion_plan_response"], &answer["cranny"]);
    assert_eq!(
        (&response["error_code"]["val"], &response["group_name"]),
        (&json!(1), &json!("arm")),
        "{answer}"
    );
    assert_eq!(proof["valid"], true);
    assert!(proof["clearance_m"].as_f64().is_some_and(|clearance_m| clearance_m >= 0.002), "{proof}");
    assert!(proof["not_checked"].is_array() && proof["deviations"].is_array(), "{proof}");
    let trajectory = &response["trajectory"]["joint_trajectory"];
    assert_eq!(trajectory["joint_names"], json!(JOINTS));
    let points = trajectory["points"].as_array().expect("points");
    let (first, last) = (&points[0], &points[points.len() - 1]);
    assert_eq!((&first["positions"], &last["positions"][0]), (&json!(START), &json!(1.2)));
    assert_eq!(first["velocities"], json!(vec![0.0; 7]));
    assert_eq!(first["accelerations"].as_array().map(Vec::len), Some(7));
    let nanoseconds = |point: &Value| {
        let time = &point["time_from_start"];
        time["sec"].as_u64().expect("seconds") * 1_000_000_000
            + time["nanosec"].as_u64().expect("nanoseconds")
    };
    assert_eq!(nanoseconds(&points[1]), 20_000_000);
    assert!(points.windows(2).all(|pair| nanoseconds(&pair[0]) < nanoseconds(&pair[1])));

    // The same request gives the same motion, whether the robot is new or known.
    assert_eq!(&server.plan(&document).1["motion_plan_response"]["trajectory"], &response["trajectory"]);
}

/// `to_flow_style_yaml` of C++ writes bytes as `0x00`, `rosidl_runtime_py` as control characters; indentation may be tabs.
#[test]
fn messages_may_be_yaml_and_written_in_any_way() {
    let server = Server::start(&[]);
    let document = request(0.4, [2.0, 0.0, 0.5], [0.1; 3]);
    let text = document.to_string();
    let (_, expected) = server.plan(&document);
    let as_byte = text.replace("\"operation\":0", "\"operation\":\"\\u0000\"");
    let as_hex = text.replace("\"operation\":0", "operation: 0x00");
    let with_tabs = text.replace(',', ",\n\t\t");
    let with_name = text.replace("\"crate\"", "\"crate \\ud83d\\udce6 \u{1f4e6}\"");
    let block = "planning_scene: {world: {collision_objects: []}}\nmotion_plan_request:\n  ".to_owned()
        + &document["motion_plan_request"].to_string();
    for written in [as_byte, as_hex, with_tabs, with_name, block] {
        let (status, answer) = server.reply("POST", "/plan", &written);
        assert_eq!(status, 200, "{written}\n{answer}");
        assert_eq!(
            answer["motion_plan_response"]["trajectory"], expected["motion_plan_response"]["trajectory"],
            "{written}"
        );
    }
}

#[test]
fn a_negative_result_is_a_response_with_the_code_of_moveit() {
    let server = Server::start(&["--time-limit", "2"]);
    let code = |document: &Value| {
        let (status, answer) = server.plan(document);
        let error = &answer["motion_plan_response"]["error_code"];
        assert_eq!(status, 200, "{answer}");
        let points = &answer["motion_plan_response"]["trajectory"]["joint_trajectory"]["points"];
        assert_eq!((points, &answer["cranny"]["valid"]), (&json!([]), &json!(false)));
        (error["val"].as_i64().expect("a number"), error["message"].as_str().expect("a text").to_owned())
    };
    // At the hand in the start, and at the hand in the goal.
    let (start, goal) = ([0.45, 0.0, 0.45], [0.163, 0.419, 0.45]);
    let (number, message) = code(&request(1.2, start, [0.3; 3]));
    assert!(number == -10 && message.contains("crate"), "{number}: {message}");
    let (number, message) = code(&request(1.2, goal, [0.25; 3]));
    assert!(number == -12 && message.contains("crate"), "{number}: {message}");
    let (number, message) = code(&request(9.0, [2.0, 0.0, 0.0], [0.1; 3]));
    assert!(number == -27 && message.contains("fr3_joint1"), "{number}: {message}");
    assert!(message.starts_with("every goal is beyond a joint limit"), "{message}");
    // Path constraints that exclude the start, and the goal.
    for (position, expected, subject) in [(0.4, -11, "the start"), (0.0, -13, "every goal")] {
        let mut constrained = request(0.4, [2.0, 0.0, 0.0], [0.1; 3]);
        constrained["motion_plan_request"]["path_constraints"] = json!({"joint_constraints": [{
            "joint_name": JOINTS[0], "position": position, "tolerance_above": 0.1, "tolerance_below": 0.1,
        }]});
        let (number, message) = code(&constrained);
        let is_told = message.starts_with(&format!("{subject} violates a path constraint: fr3_joint1 is "));
        assert!(
            number == expected && is_told && message.contains("the range of its path constraint"),
            "{number}: {message}"
        );
    }
}

#[test]
fn a_bad_request_is_told_the_entry_and_the_fault() {
    let server = Server::start(&[]);
    let good = request(0.4, [2.0, 0.0, 0.5], [0.1; 3]);
    let changed = |change: &dyn Fn(&mut Value)| {
        let mut document = good.clone();
        change(&mut document);
        document.to_string()
    };
    let joint = |request: &mut Value, value: Value| {
        request["motion_plan_request"]["goal_constraints"][0]["joint_constraints"][2]["position"] = value;
    };
    let text = good.to_string();
    let cases = [
        (String::new(), "request: "),
        ("[]".to_owned(), "a mapping with planning_scene and motion_plan_request"),
        ("{}".to_owned(), "request: missing field `planning_scene`"),
        (text[..text.len() / 2].to_owned(), "request:1: "),
        (changed(&|document| document["more"] = json!(1)), "request: unknown field `more`"),
        (changed(&|document| document["planning_scene"] = json!({})), "planning_scene: no world"),
        (
            changed(&|document| joint(document, json!("NaN"))),
            "motion_plan_request.goal_constraints[0].joint_constraints[2].position: ",
        ),
        (text.replace("\"position\":0.8", "\"position\":NaN"), "joint_constraints[6].position: "),
        (text.replace("\"position\":0.8", "\"position\":1e999"), "is not a finite number"),
        (
            changed(&|document| {
                document["planning_scene"]["world"]["collision_objects"][0]["planes"] = json!([{}]);
            }),
            "planning_scene.world.collision_objects[0].planes: a plane",
        ),
        (
            changed(&|document| document["planning_scene"]["is_diff"] = json!(true)),
            "planning_scene.is_diff: ",
        ),
        (changed(&|document| document["motion_plan_request"]["group_name"] = json!("leg")), "`leg`"),
        (
            changed(&|document| document["motion_plan_request"]["allowed_planning_time"] = json!(-1.0)),
            "motion_plan_request.allowed_planning_time: ",
        ),
        (text.replacen("\"id\":", "\"id\":\"a\",\"id\":", 1), "is given twice"),
        ("[".repeat(100_000), "recursion limit"),
    ];
    for (content, expected) in cases {
        let (status, answer) = server.reply("POST", "/plan", &content);
        let error = answer["error"].as_str().unwrap_or_default();
        assert_eq!(status, 400, "{expected}: {answer}");
        assert!(error.contains(expected) && !error.contains('\n'), "no '{expected}' in '{error}'");
    }
    assert_eq!(server.plan(&good).0, 200);
}

#[test]
fn what_is_too_large_or_elsewhere_is_refused() {
    let server = Server::start(&[]);
    let (status, answer) = server.reply("POST", "/plan", &" ".repeat((64 << 20) + 1));
    assert_eq!(status, 413, "{answer}");
    for (method, path, expected) in
        [("GET", "/plan", 405), ("POST", "/", 405), ("DELETE", "/", 405), ("GET", "/etc/passwd", 404)]
    {
        assert_eq!(server.reply(method, path, "").0, expected, "{method} {path}");
    }
    let document = request(0.4, [2.0, 0.0, 0.5], [0.1; 3]).to_string();
    for path in ["/", "/plan", &format!("/{}/plan", "0".repeat(32))] {
        assert_eq!(received(server.send("POST", path, &document)).0, 403, "{path} without the token");
    }
}

/// Returns a request that no search can answer: the goal is behind walls around the arm.
fn endless() -> Value {
    let mut document = request(2.5, [0.0, 0.0, 1.5], [3.0, 3.0, 0.1]);
    let objects = &mut document["planning_scene"]["world"]["collision_objects"];
    let crate_of = |id: &str, position: [f64; 3], size: [f64; 3]| {
        let mut wall =
            request(0.0, position, size)["planning_scene"]["world"]["collision_objects"][0].clone();
        wall["id"] = id.into();
        wall
    };
    let walls = [
        crate_of("left", [0.0, 0.9, 0.5], [3.0, 1.2, 2.0]),
        crate_of("back", [-1.0, 0.0, 0.5], [1.6, 3.0, 2.0]),
    ];
    objects.as_array_mut().expect("a list").extend(walls);
    document
}

#[test]
fn a_search_ends_with_its_time_with_its_client_and_with_the_server() {
    let mut server = Server::start(&["--time-limit", "60"]);
    // The shelf of goals: each of many is free, but cut off.
    let mut document = endless();
    document["motion_plan_request"]["allowed_planning_time"] = json!(0.3);
    let begin = Instant::now();
    let (status, answer) = server.plan(&document);
    let code = &answer["motion_plan_response"]["error_code"];
    assert_eq!(status, 200, "{answer}");
    assert_ne!(code["val"], 1, "{code}");
    assert!(begin.elapsed() < Duration::from_secs(20), "{:?}", begin.elapsed());

    // A client that leaves; the next request is answered long before the time of the first is over.
    document["motion_plan_request"]["allowed_planning_time"] = json!(60.0);
    let path = format!("/{}/plan", server.token);
    drop(server.send("POST", &path, &document.to_string()));
    let begin = Instant::now();
    assert_eq!(server.plan(&request(0.4, [2.0, 0.0, 0.5], [0.1; 3])).0, 200);
    assert!(begin.elapsed() < Duration::from_secs(20), "{:?}", begin.elapsed());

    let waiting = server.send("POST", &path, &document.to_string());
    std::thread::sleep(Duration::from_millis(300));
    let begin = Instant::now();
    #[cfg(unix)]
    assert!(
        Command::new("kill").args(["-INT", &server.child.id().to_string()]).status().expect("kill").success()
    );
    #[cfg(unix)]
    assert_eq!(server.child.wait().expect("it ends").code(), Some(0));
    assert!(begin.elapsed() < Duration::from_secs(5), "{:?}", begin.elapsed());
    drop(waiting);
}

#[test]
fn a_robot_that_is_none_is_refused_at_the_start() {
    let refused = |arguments: &[&str]| -> String {
        let output: Output = Command::new(env!("CARGO_BIN_EXE_cranny"))
            .arg("serve")
            .args(arguments)
            .output()
            .expect("it runs");
        assert_eq!(output.status.code(), Some(2));
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(refused(&[]).contains("--robot"));
    assert!(refused(&["--robot", "nowhere.urdf"]).contains("nowhere.urdf"));
    assert!(refused(&["--robot", "fr3", "--srdf", "nowhere.srdf"]).contains("nowhere.srdf"));
    assert!(refused(&["--robot", "fr3", "--rate", "0"]).contains("samples per second"));
}
