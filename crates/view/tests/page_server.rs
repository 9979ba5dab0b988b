//! Tests of the page server: it serves only this machine and its own files, and stops on request.

use std::io::{Read, Write};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpStream};
use std::sync::{Arc, mpsc};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use cranny_collision::{Cell, Margins};
use cranny_plan::Observer as _;
use cranny_scenario::{OpenOptions, Scenario};
use cranny_spatial::Stream;
use cranny_view::{PageCells, PageData, PageFeed, PageServer, PageSettings, ServerLimits, ViewError};
use serde_json::{Value, json};
use tokio::sync::oneshot;

/// Server that runs until it is dropped.
struct Running {
    port: u16,
    /// Prefix of every path: `/` and the token.
    inside: String,
    cell: Arc<Cell>,
    feed: PageFeed,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<Result<(), ViewError>>>,
}

impl Running {
    fn start() -> Self {
        Self::with(ServerLimits::default())
    }

    fn with(limits: ServerLimits) -> Self {
        let scenario = Scenario::open("021", &OpenOptions::default()).expect("a built-in scenario");
        let problem = scenario.problem(Margins::default()).expect("a problem");
        let cell = problem.cell().expect("an exact problem").clone();
        let page = PageData::of(&scenario, &[], &cell, &[], PageSettings::default()).expect("a page");
        let server = PageServer::bind(0, limits).expect("a free port");
        let url = server.url();
        let address = url.strip_prefix("http://").and_then(|rest| rest.strip_suffix('/'));
        let (address, token) = address.and_then(|rest| rest.split_once('/')).expect("an address and a token");
        let inside = format!("/{token}");
        let address: SocketAddr = address.parse().expect("an address");
        assert_eq!(address.ip(), IpAddr::V4(Ipv4Addr::LOCALHOST));
        let (stop, told) = oneshot::channel();
        let (tell_ready, ready) = mpsc::channel();
        let of_server = Some(PageCells::of(cell.clone(), &[]));
        let feed = PageFeed::new(&page, true).expect("a page");
        let of_thread = feed.clone();
        let thread = std::thread::spawn(move || {
            let stop = async {
                let _ = told.await;
            };
            server.serve_feed(of_thread, of_server, stop, || tell_ready.send(()).expect("somebody waits"))
        });
        ready.recv().expect("it is ready");
        Self { port: address.port(), inside, cell, feed, stop: Some(stop), thread: Some(thread) }
    }

    fn host(&self) -> String {
        format!("127.0.0.1:{}", self.port)
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect((Ipv4Addr::LOCALHOST, self.port)).expect("it listens");
        stream.set_read_timeout(Some(Duration::from_secs(30))).expect("a timeout");
        stream
    }

    /// Sends a raw request and returns status, head and content.
    fn raw(&self, request: &str) -> (u16, String, String) {
        let mut stream = self.connect();
        stream.write_all(request.as_bytes()).expect("it reads");
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).expect("it answers");
        let answer = String::from_utf8_lossy(&answer).into_owned();
        let (head, body) = answer.split_once("\r\n\r\n").expect("a head and a body");
        let status = head.split(' ').nth(1).and_then(|status| status.parse().ok()).expect("a status");
        (status, head.to_lowercase(), body.to_owned())
    }

    /// Requests a path below the token.
    fn get(&self, path: &str, host: &str) -> (u16, String, String) {
        self.get_bare(&format!("{}{path}", self.inside), host)
    }

    fn get_bare(&self, path: &str, host: &str) -> (u16, String, String) {
        self.raw(&format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n"))
    }

    fn ask(&self, body: &str) -> (u16, Value) {
        let (host, length, inside) = (self.host(), body.len(), &self.inside);
        let (status, _, answer) = self.raw(&format!(
            "POST {inside}/verdict HTTP/1.1\r\nHost: {host}\r\nContent-Type: application/json\r\n\
             Content-Length: {length}\r\nConnection: close\r\n\r\n{body}"
        ));
        (status, serde_json::from_str(&answer).expect("JSON"))
    }

    fn end(&mut self) -> Result<(), ViewError> {
        if let Some(stop) = self.stop.take() {
            stop.send(()).expect("it runs");
        }
        self.thread.take().map_or(Ok(()), |thread| thread.join().expect("no panic"))
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.end();
    }
}

#[test]
fn the_page_gets_its_data_and_a_policy_that_forbids_the_network() {
    let server = Running::start();
    let (status, head, body) = server.get("/page.json", &server.host());
    assert_eq!(status, 200);
    let page: Value = serde_json::from_str(&body).expect("JSON");
    assert_eq!((&page["name"], &page["is_live"]), (&"021".into(), &true.into()));
    for header in ["content-type: application/json", "x-content-type-options: nosniff", "default-src 'none'"]
    {
        assert!(head.contains(header), "no '{header}' in {head}");
    }
    assert!(!head.contains("http:") && !head.contains("https:"), "{head}");
    let (status, _, _) = server.get("/page.json", &format!("localhost:{}", server.port));
    assert_eq!(status, 200);
}

#[test]
fn the_page_itself_is_served_where_the_program_has_one() {
    if let Err(missing) = PageServer::check_page() {
        assert!(missing.to_string().contains("Node"), "{missing}");
        assert!(std::env::var_os("CRANNY_REQUIRE_ALL").is_none(), "{missing}");
        eprintln!("SKIPPED: the page itself ({missing})");
        return;
    }
    let server = Running::start();
    let (status, head, body) = server.get("/", &server.host());
    assert_eq!(status, 200);
    assert!(head.contains("content-type: text/html") && head.contains("script-src 'self'"), "{head}");
    assert!(body.to_lowercase().starts_with("<!doctype html>"));
    assert_eq!(server.get("/index.html", &server.host()).2, body);
}

#[test]
fn a_search_that_is_watched_is_handed_out_as_it_grows() {
    let server = Running::start();
    let asked = |path: &str| {
        let (status, _, body) = server.get(path, &server.host());
        (status, serde_json::from_str::<Value>(&body).unwrap_or(body.into()))
    };
    let mut search = server.feed.watch(server.cell.robot().clone());
    assert_eq!(asked("/news?after=0").1["tree"], json!({"search": 1, "nodes": 0}));
    let q = vec![0.0; server.cell.robot().dof()];
    search.node_added(0, &q, None);
    search.node_added(0, &q, Some(0));
    search.search_ended();
    let news = asked("/news?after=1").1;
    assert_eq!((&news["tree"], &news["poses"]), (&json!({"search": 1, "nodes": 2}), &0.into()));
    let bytes = |row: &Value| row.as_str().map_or(0, |text| text.len() / 4 * 3);
    let (status, all) = asked("/tree?search=1&after=0");
    assert_eq!((status, &all["from"], bytes(&all["positions"])), (200, &0.into(), 2 * 3 * 4));
    let last = asked("/tree?search=1&after=1").1;
    assert_eq!((&last["from"], bytes(&last["positions"])), (&1.into(), 3 * 4));
    assert_eq!(asked("/tree?search=1&after=9").1["positions"], "");
    assert_eq!((asked("/tree?search=2&after=0").0, asked("/tree?search=x").0), (404, 400));
    // A second search replaces the first, whose nodes are no longer served.
    let second = server.feed.watch(server.cell.robot().clone());
    search.node_added(0, &q, Some(0));
    search.search_ended();
    assert_eq!(asked("/news?after=0").1["tree"], json!({"search": 2, "nodes": 0}));
    assert_eq!((asked("/tree?search=1&after=0").0, search.end().len(), second.end().len()), (404, 3, 0));
}

#[test]
fn nothing_outside_the_page_is_served() {
    let server = Running::start();
    let paths = [
        "/../Cargo.toml",
        "/../../../../../../etc/passwd",
        "/%2e%2e/%2e%2e/etc/passwd",
        "/%2e%2e%2f%2e%2e%2fetc%2fpasswd",
        "/..%5c..%5cetc%5cpasswd",
        "/./../etc/passwd",
        "//etc/passwd",
        "/etc/passwd",
        "/assets/../../etc/passwd",
        "/assets/",
        "/%00",
        "/C:/Windows/win.ini",
        "/page.json/../etc/passwd",
    ];
    for path in paths {
        let (status, _, body) = server.get(path, &server.host());
        assert!([400, 404].contains(&status), "{path}: {status}");
        assert!(!body.contains("root:") && !body.contains("[package]"), "{path}: {body}");
        assert_eq!(server.get_bare(path, &server.host()).0, 403, "{path} without the token");
    }
    // An absolute address instead of a path changes nothing.
    let absolute =
        format!("GET file:///etc/passwd HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n\r\n", server.host());
    assert!([400, 403].contains(&server.raw(&absolute).0));
}

#[test]
fn other_hosts_and_other_origins_are_turned_away() {
    let server = Running::start();
    let port = server.port;
    for host in [
        "evil.example",
        &format!("evil.example:{port}"),
        "127.0.0.1:1",
        "127.0.0.1",
        "",
        &format!("0.0.0.0:{port}"),
    ] {
        let (status, _, body) = server.get("/page.json", host);
        assert!([400, 403].contains(&status), "'{host}': {status}");
        assert!(!body.contains("cranny-page"), "'{host}'");
    }
    let body = json!({"q": vec![0.0; server.cell.robot().dof()]}).to_string();
    for (origin, expected) in [
        ("http://evil.example".to_owned(), 403),
        ("null".to_owned(), 403),
        (format!("http://127.0.0.1:{port}"), 200),
    ] {
        let (status, _, _) = server.raw(&format!(
            "POST {}/verdict HTTP/1.1\r\nHost: {}\r\nOrigin: {origin}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{body}",
            server.inside,
            server.host(),
            body.len()
        ));
        assert_eq!(status, expected, "{origin}");
    }
}

/// Every user of a machine can open its loopback ports and request the scenes of other users.
#[test]
fn who_does_not_know_the_token_gets_nothing() {
    let server = Running::start();
    let host = server.host();
    let token = server.inside.trim_start_matches('/').to_owned();
    let cut = &token[..token.len() - 1];
    let last = if token.ends_with('0') { '1' } else { '0' };
    for prefix in [
        String::new(),
        format!("/{}", "0".repeat(token.len())),
        format!("/{cut}"),
        format!("/{cut}{last}"),
        format!("/{token}0"),
        format!("//{token}"),
        format!("/%{:02x}{}", token.as_bytes()[0], &token[1..]),
        format!("/x/../{token}"),
    ] {
        for path in ["/", "/page.json", "/index.html", "/verdict", &format!("/page.json?token={token}")] {
            let (status, _, body) = server.get_bare(&format!("{prefix}{path}"), &host);
            assert_eq!(status, 403, "{prefix}{path}");
            assert!(!body.contains("cranny-page") && !body.contains(&token), "{prefix}{path}: {body}");
        }
    }
    let q = json!({"q": vec![0.0; server.cell.robot().dof()]}).to_string();
    let (status, _, body) = server.raw(&format!(
        "POST /verdict HTTP/1.1\r\nHost: {host}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{q}",
        q.len()
    ));
    assert_eq!(status, 403, "{body}");
    // This is the printed address without its trailing slash.
    let (status, head, _) = server.get("", &host);
    assert_eq!(status, 308);
    assert!(head.contains(&format!("location: {}/", server.inside)), "{head}");
    let other = PageServer::bind(0, ServerLimits::default()).expect("a free port").url();
    assert!(!other.contains(&token), "two servers have the same token");
}

const QUICK: ServerLimits = ServerLimits {
    connections: 2,
    request: Duration::from_millis(100),
    connection: Duration::from_millis(400),
};

/// Slowloris: without a timeout, a head or content that arrives byte by byte would occupy its connection forever.
#[test]
fn who_sends_slowly_is_cut() {
    let server = Running::with(QUICK);
    let (host, inside) = (server.host(), &server.inside);
    let head = format!("POST {inside}/verdict HTTP/1.1\r\nHost: {host}\r\nContent-Length: 60000\r\n\r\n");
    for (whole, drop) in [("GET /page.json HTTP/1.1\r\n", "a"), (&head, " ")] {
        let mut stream = server.connect();
        stream.write_all(whole.as_bytes()).expect("it reads");
        let begin = Instant::now();
        // Data is sent slowly until the server closes the connection.
        while begin.elapsed() < Duration::from_secs(20) && stream.write_all(drop.as_bytes()).is_ok() {
            std::thread::sleep(Duration::from_millis(10));
        }
        assert!(begin.elapsed() < Duration::from_secs(10), "still open after {whole}");
    }
    assert_eq!(server.get("/page.json", &host).0, 200);
}

/// Few connections, none of which ends by a timeout within the test.
const PATIENT: ServerLimits =
    ServerLimits { connections: 8, request: Duration::from_hours(1), connection: Duration::from_hours(1) };

/// Returns the number of connections that the server has not closed.
fn open(connections: &mut [TcpStream]) -> usize {
    let is_open = |stream: &mut TcpStream| {
        stream.set_nonblocking(true).expect("a socket");
        loop {
            match stream.read(&mut [0; 8192]) {
                Ok(0) => return false,
                Ok(_) => {}
                Err(reason) => return reason.kind() == std::io::ErrorKind::WouldBlock,
            }
        }
    };
    connections.iter_mut().map(is_open).filter(|is_open| *is_open).count()
}

/// With connections that wait for a free one, nine silent clients would block the user until their timeout.
#[test]
fn a_user_is_answered_whatever_many_others_leave_undone() {
    let server = Running::with(PATIENT);
    let (host, inside) = (server.host(), &server.inside);
    let whole = format!("GET {inside}/page.json HTTP/1.1\r\nHost: {host}\r\n\r\n");
    let question = format!("POST {inside}/verdict HTTP/1.1\r\nHost: {host}\r\nContent-Length: 9\r\n\r\n{{");
    // Silent clients, a byte, half a head, half a question, and clients that do not read the answer.
    for sent in ["", "G", &whole[..whole.len() - 2], &question, &whole] {
        let mut others: Vec<TcpStream> = (0..100).map(|_| server.connect()).collect();
        for other in &mut others {
            // The server may have closed it meanwhile.
            let _ = other.write_all(sent.as_bytes());
        }
        for _ in 0..3 {
            assert_eq!(server.get("/page.json", &host).0, 200, "'{sent}'");
        }
        assert!(open(&mut others) <= PATIENT.connections, "'{sent}'");
    }
}

#[test]
fn a_silent_client_does_not_displace_one_that_waits_for_news() {
    let server = Running::with(PATIENT);
    let mut waiting = server.connect();
    let news = format!("GET {}/news?after=0 HTTP/1.1\r\nHost: {}\r\n\r\n", server.inside, server.host());
    waiting.write_all(news.as_bytes()).expect("it reads");
    // Its request has arrived once a later one is answered.
    assert_eq!(server.get("/news", &server.host()).0, 400);
    let silent: Vec<TcpStream> = (0..100).map(|_| server.connect()).collect();
    assert_eq!(server.get("/news", &server.host()).0, 400);
    server.feed.pose(None);
    let mut answer = String::new();
    waiting.read_to_string(&mut answer).expect("it answers");
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    drop(silent);
}

#[test]
fn a_connection_carries_one_request() {
    let server = Running::start();
    let one = format!("GET {}/page.json HTTP/1.1\r\nHost: {}\r\n\r\n", server.inside, server.host());
    let (status, head, body) = server.raw(&format!("{one}{one}"));
    assert_eq!(status, 200);
    assert!(head.contains("connection: close"), "{head}");
    assert!(!body.contains("HTTP/1.1"), "two answers");
}

#[test]
fn verdicts_are_those_of_the_cell() {
    let server = Running::start();
    let cell = &server.cell;
    let mut scratch = cell.scratch();
    let mut random = Stream::new(7, 0);
    let (mut free, mut touching) = (0, 0);
    for _ in 0..40 {
        let limits = cell.robot().limits();
        let q: Vec<f64> = limits.iter().map(|l| random.uniform_between(l.lower, l.upper)).collect();
        let (status, verdict) = server.ask(&json!({ "q": q }).to_string());
        assert_eq!(status, 200);
        let is_free = cell.is_free(&q, &mut scratch);
        assert_eq!(verdict["is_free"], is_free);
        let contacts = cell.contacts(&q, &mut scratch);
        let named: Vec<Value> = contacts
            .iter()
            .map(|c| json!({"first": cell.name(c.first), "second": cell.name(c.second)}))
            .collect();
        assert_eq!(verdict["contacts"], Value::from(named));
        let clearance_m = verdict["clearance_m"].as_f64().expect("a number");
        if is_free {
            assert!((clearance_m - cell.clearance(&q, &mut scratch)).abs() < 1e-9);
        } else {
            let deepest = contacts.iter().map(|c| c.depth_m).fold(0.0, f64::max);
            assert!((clearance_m + deepest).abs() < 1e-9 || clearance_m < 1e-5, "{clearance_m} {deepest}");
        }
        let frames = cell.robot().frames_at(&q);
        let gripper = frames.link(cell.robot().tip()).translation.vector;
        for (axis, value) in gripper.iter().enumerate() {
            let told = verdict["world_from_gripper"][axis].as_f64().expect("a number");
            assert!((told - value).abs() < 1e-12);
        }
        free += usize::from(is_free);
        touching += usize::from(!is_free);
    }
    assert!(free > 2 && touching > 2, "{free} free, {touching} touching");
}

#[test]
fn a_joint_beyond_its_limit_is_named() {
    let server = Running::start();
    let robot = server.cell.robot();
    let mut q = vec![0.0, 0.0, -0.0178, -0.7601, 0.0198, -2.3421, 0.0298, 1.5412, 0.7534];
    assert_eq!(server.ask(&json!({ "q": q }).to_string()).1["contacts"], json!([]));
    q[0] = 1.5;
    let (status, verdict) = server.ask(&json!({ "q": q }).to_string());
    assert_eq!((status, &verdict["is_free"]), (200, &false.into()));
    let expected = json!({"first": robot.joint_names()[0], "second": "joint limit"});
    assert!(verdict["contacts"].as_array().is_some_and(|contacts| contacts.contains(&expected)), "{verdict}");
}

#[test]
fn a_malformed_question_is_told_what_is_wrong() {
    let server = Running::start();
    let dof = server.cell.robot().dof();
    let full = |value: &str| format!("{{\"q\": [{}]}}", vec![value; dof].join(", "));
    let cases = [
        (String::new(), "JSON"),
        ("{}".to_owned(), "missing field `q`"),
        ("{\"q\": 1}".to_owned(), "invalid type"),
        ("{\"q\": []}".to_owned(), "'q' has 0 values, but the robot has 9 joints"),
        ("{\"q\": [1, 2]}".to_owned(), "'q' has 2 values"),
        (full("NaN"), "JSON"),
        (full("null"), "invalid type"),
        (full("1e999"), "out of range"),
        (full("\"0\""), "invalid type"),
        ("\u{0}\u{1}".to_owned(), "JSON"),
        (full("0")[..20].to_owned(), "EOF"),
    ];
    for (body, word) in cases {
        let (status, answer) = server.ask(&body);
        let message = answer["error"].as_str().expect("an error");
        assert_eq!(status, 400, "{body}: {message}");
        assert!(message.contains(word), "no '{word}' in '{message}'");
    }
    let (status, answer) = server.ask(&full(&format!("0.{}", "0".repeat(20_000))));
    assert_eq!(status, 413, "{answer}");
    assert!(answer["error"].is_string());
}

#[test]
fn news_is_asked_for_after_a_number_of_changes() {
    let server = Running::start();
    for path in ["/news", "/news?after=x", "/news?before=1"] {
        let (status, _, body) = server.get(path, &server.host());
        assert_eq!(status, 400, "{path}");
        assert!(body.contains("news?after=0"), "{body}");
    }
}

#[test]
fn other_methods_are_refused() {
    let server = Running::start();
    for (method, path) in [("POST", "/page.json"), ("DELETE", "/"), ("PUT", "/verdict"), ("GET", "/verdict")]
    {
        let request = format!(
            "{method} {}{path} HTTP/1.1\r\nHost: {}\r\nContent-Length: 0\r\nConnection: close\r\n\r\n",
            server.inside,
            server.host()
        );
        assert_eq!(server.raw(&request).0, 405, "{method} {path}");
    }
}

#[test]
fn it_stops_when_told_even_with_a_client_that_says_nothing() {
    let mut server = Running::start();
    let mut silent = TcpStream::connect((Ipv4Addr::LOCALHOST, server.port)).expect("it listens");
    silent.write_all(b"GET /page.json HTTP/1.1\r\nHo").expect("it reads");
    server.end().expect("a clean end");
    assert!(TcpStream::connect((Ipv4Addr::LOCALHOST, server.port)).is_err(), "nobody listens any more");
}

#[test]
fn a_port_that_is_taken_is_an_error_with_a_hint() {
    let server = PageServer::bind(0, ServerLimits::default()).expect("a free port");
    let url = server.url();
    let port = url.rsplit(':').next().and_then(|rest| rest.split('/').next()?.parse().ok()).expect("a port");
    let message = PageServer::bind(port, ServerLimits::default()).expect_err("it is taken").to_string();
    assert!(message.contains(&port.to_string()) && message.contains("--port"), "{message}");
}
