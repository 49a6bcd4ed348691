//! The language server, driven over its standard input and output as an editor does.

use std::path::Path;

use compiler::preprocess::Includes;
use compiler::source::SourceMap;
use serde_json::{Value, json};

use crate::client::Client;
use crate::gmlvm::Sandbox;

#[path = "support/client.rs"]
mod client;
#[allow(dead_code, reason = "it serves several test programs")]
#[path = "support/gmlvm.rs"]
mod gmlvm;

const URI: &str = "file:///tmp/scene.gml";

fn at(uri: &str, line: u32, character: u32) -> Value {
    json!({ "textDocument": { "uri": uri }, "position": { "line": line, "character": character } })
}

/// `LINE:COLUMN-LINE:COLUMN`, as the protocol counts.
fn range(value: &Value) -> String {
    let place = |end: &str| format!("{}:{}", value[end]["line"], value[end]["character"]);
    format!("{}-{}", place("start"), place("end"))
}

/// Severity, code, range and the first line of the message of each diagnostic.
fn shown(diagnostics: &[Value]) -> Vec<String> {
    let show = |found: &Value| {
        let message = found["message"].as_str().expect("text").lines().next().expect("a line");
        let code = found["code"].as_str().expect("text");
        assert_eq!(found["source"], "gmlvm");
        format!("{} {code} {} {message}", found["severity"], range(&found["range"]))
    };
    diagnostics.iter().map(show).collect()
}

/// What the server finds in one text.
fn check(text: &str) -> Vec<Value> {
    let mut client = Client::new(&[]);
    client.open(URI, text);
    let found = client.diagnostics(URI, 1);
    assert_eq!(client.quit(), 0);
    found
}

#[test]
fn diagnostics_are_those_of_check() {
    // The places of both, of the same scenes; columns of `check` count characters from 1.
    let scenes = [
        "1 addi",
        "1 { /x x\n  { /y y }\napply\n",
        "1 99999999999999999999 1e999",
        "{ /addi }",
        "0.4 /radius raduis",
        "1 2.0 addi",
        "[ 1 ] 3 get",
        "\"open\n1",
        &"{ ".repeat(600),
    ];
    for scene in scenes {
        let sandbox = Sandbox::new();
        sandbox.file("a.gml", scene);
        let ended = sandbox.run(&["check", "a.gml", "--message-format", "json"]);
        let lines = ended.stderr.lines().map(|line| serde_json::from_str(line).expect("JSON"));
        let expected = lines.map(|found: Value| {
            let place = &found["spans"][0];
            let number = |name: &str| place[name].as_i64().expect("a number") - 1;
            let [line, column] = ["line", "column"].map(number);
            let [end_line, end_column] = ["end_line", "end_column"].map(number);
            let code = found["code"].as_str().expect("text");
            let message = found["message"].as_str().expect("text");
            format!("1 {code} {line}:{column}-{end_line}:{end_column} {message}")
        });
        let expected: Vec<_> = expected.collect();
        assert!(!expected.is_empty(), "{scene}");
        assert_eq!(shown(&check(scene)), expected, "{scene}");
    }
    assert!(check("1 2 addi").is_empty());
}

#[test]
fn places_count_utf_16_and_changes_follow_them() {
    let mut client = Client::new(&[]);
    client.open(URI, "% \u{1f98a}\u{e9}\r\n/* \u{1f98a} */ 1 addi\n");
    let found = client.diagnostics(URI, 1);
    assert_eq!(
        shown(&found),
        [
            "1 E0101 1:11-1:15 the stack has too few values: `addi` takes 2 operands (integer, integer)"
        ]
    );
    // The fox goes, and behind it another operand comes.
    let change = |start: [u32; 2], end: [u32; 2], text: &str| {
        let place = |[line, character]: [u32; 2]| json!({ "line": line, "character": character });
        json!({ "range": { "start": place(start), "end": place(end) }, "text": text })
    };
    let changes = json!([change([1, 3], [1, 5], ""), change([1, 7], [1, 8], "1 2")]);
    client.change(URI, 2, changes);
    assert_eq!(shown(&client.diagnostics(URI, 2)), [""; 0]);
    let hover = client.request("textDocument/hover", at(URI, 1, 12));
    assert_eq!(range(&hover["range"]), "1:11-1:15");
    client.change(URI, 3, json!([{ "text": "x" }]));
    assert_eq!(shown(&client.diagnostics(URI, 3)), ["1 E0102 0:0-0:1 `x` is not bound"]);
    assert_eq!(client.quit(), 0);
}

#[test]
fn related_places_advice_and_corrections() {
    let text = "0.4 /radius\n{ /r r raduis mulf } /f\n1.0 f apply 1\n";
    let mut client = Client::new(&[]);
    client.open(URI, text);
    let found = client.diagnostics(URI, 1);
    assert_eq!(shown(&found), ["1 E0102 1:7-1:13 `raduis` is not bound"]);
    let message = found[0]["message"].as_str().expect("text");
    assert!(message.ends_with("help: did you mean `radius`?"), "{message}");
    let related = found[0]["relatedInformation"].as_array().expect("a list");
    let related: Vec<_> = related
        .iter()
        .map(|r| format!("{} {}", range(&r["location"]["range"]), r["message"]))
        .collect();
    assert_eq!(
        related,
        [
            "0:4-0:11 \"a similar name is bound here\"",
            "2:6-2:11 \"called here, in the main program\""
        ]
    );
    let params = json!({
        "textDocument": { "uri": URI }, "range": found[0]["range"], "context": { "diagnostics": found }
    });
    let actions = client.request("textDocument/codeAction", params);
    assert_eq!(actions[0]["title"], "Change to `radius`");
    let edit = &actions[0]["edit"]["changes"][URI][0];
    assert_eq!(
        (range(&edit["range"]), &edit["newText"]),
        ("1:7-1:13".to_owned(), &json!("radius"))
    );
    assert_eq!(client.quit(), 0);
}

#[test]
fn surface_functions_are_not_run_but_their_names_are_looked_up() {
    let text = "{ /v /u /face colour 1.0 0.0 1.0 } sphere /ball";
    let found = check(text);
    assert_eq!(shown(&found), ["2 E0102 0:14-0:20 `colour` is not bound"]);
    let text = "1.0 /shine { /v /u /face 1.0 1.0 1.0 point 1.0 0.0 shien } sphere /ball";
    let found = check(text);
    assert_eq!(shown(&found), ["2 E0102 0:51-0:56 `shien` is not bound"]);
    assert_eq!(found[0]["data"]["replacement"], "shine");
    // Within the limits of an editor, which are no error.
    let found = check("{ /f f f apply } /f f f apply");
    assert!(shown(&found)[0].starts_with("2 E0401 "), "{found:?}");
}

/// Renames every binding of some scenes in turn: the same program is left, but for its names.
#[test]
fn renamed_scenes_are_the_same_programs() {
    let mut n_renamed = 0;
    for name in ["hello", "mandelbrot", "texture-faces", "chicago-attenuation"] {
        let path = format!("{}/scenes/{name}.gml", env!("CARGO_MANIFEST_DIR"));
        let uri = format!("file://{path}");
        let text = std::fs::read_to_string(&path).expect("part of the project");
        let mut client = Client::new(&[]);
        client.open(&uri, &text);
        let expected = code(&path, &text);
        for (line, content) in text.lines().enumerate().filter(|(_, l)| !l.starts_with(['%', '#']))
        {
            for (column, _) in content.match_indices('/') {
                let mut params = at(&uri, line as u32, column as u32 + 1);
                params["newName"] = json!("another-name");
                let edits = client.request("textDocument/rename", params);
                let edits = edits["changes"][&uri].as_array().expect("a list").clone();
                let renamed = apply(&text, &edits);
                assert_ne!(renamed, text);
                assert_eq!(code(&path, &renamed), expected, "{name}:{}:{column}", line + 1);
                n_renamed += 1;
            }
        }
        assert_eq!(client.quit(), 0);
    }
    assert!(n_renamed > 40, "only {n_renamed} bindings");
}

/// Reads files beside the including one.
struct Beside;

impl Includes for Beside {
    fn load(&mut self, from: &str, name: &str) -> Option<(String, Vec<u8>)> {
        let path = Path::new(from).with_file_name(name);
        Some((path.display().to_string(), std::fs::read(&path).ok()?))
    }
}

/// The instructions and constants of a scene.
fn code(path: &str, text: &str) -> Vec<String> {
    let mut sources = SourceMap::default();
    let file = sources.add(path, text.as_bytes().to_vec()).expect("short");
    let program = compiler::compile(&mut sources, file, &mut Beside, &[]).expect("correct");
    let functions = program.functions.iter();
    functions.map(|f| format!("{:?} {:?} {:?}", f.code, f.constants, f.captures)).collect()
}

/// A text of one byte a character, edited.
fn apply(text: &str, edits: &[Value]) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let number = |value: &Value| value.as_u64().expect("a number") as usize;
    let mut places: Vec<_> = edits
        .iter()
        .map(|edit| {
            let (start, end) = (&edit["range"]["start"], &edit["range"]["end"]);
            assert_eq!(start["line"], end["line"]);
            let columns = number(&start["character"])..number(&end["character"]);
            (number(&start["line"]), columns, edit["newText"].as_str().expect("text"))
        })
        .collect();
    places.sort_by_key(|(line, columns, _)| (*line, columns.start));
    for (line, columns, new) in places.into_iter().rev() {
        lines[line].replace_range(columns, new);
    }
    lines.join("\n") + "\n"
}

#[test]
fn nothing_is_wrong_with_the_scenes_of_the_project() {
    let folder = format!("{}/scenes", env!("CARGO_MANIFEST_DIR"));
    let mut client = Client::new(&[]);
    let mut n_scenes = 0;
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("readable").path();
        if path.extension().is_none_or(|extension| extension != "gml") {
            continue;
        }
        let text = std::fs::read_to_string(&path).expect("text");
        let uri = format!("file://{}", path.display());
        client.open(&uri, &text);
        assert_eq!(shown(&client.diagnostics(&uri, 1)), [""; 0], "{uri}");
        n_scenes += 1;
    }
    assert!(n_scenes >= 12, "only {n_scenes} scenes");
    assert_eq!(client.quit(), 0);
}

#[test]
fn files_are_taken_as_they_stand_in_the_editor() {
    let sandbox = Sandbox::new();
    let scene = "#include \"lib/size.ins\"\nsize 1 addi\n";
    sandbox.file("a b.gml", scene).file("lib/size.ins", "% How large.\n2 /size\n");
    let folder = sandbox.path("").display().to_string();
    let (uri, included) =
        (format!("file://{folder}a%20b.gml"), format!("file://{folder}lib/size.ins"));
    let mut client = Client::new(&[]);
    client.open(&uri, scene);
    assert_eq!(shown(&client.diagnostics(&uri, 1)), [""; 0]);
    let place = client.request("textDocument/definition", at(&uri, 1, 1));
    assert_eq!(
        (place["uri"].as_str(), range(&place["range"]).as_str()),
        (Some(&*included), "1:3-1:7")
    );
    let hover = client.request("textDocument/hover", at(&uri, 1, 1));
    let hover = hover["contents"]["value"].as_str().expect("text");
    assert!(hover.contains("2 /size") && hover.contains("an integer, bound in line 2, from"));
    assert!(hover.starts_with("```gml\n% How large.\n2 /size\n```\n"), "{hover}");
    let refused = client.try_request("textDocument/rename", {
        let mut params = at(&uri, 1, 1);
        params["newName"] = json!("extent");
        params
    });
    assert!(refused.expect_err("refused").contains("other scenes may include"));
    // What is open counts, saved or not; on its own a part of a scene is not run.
    client.open(&included, "2.5 /size outer");
    let found = client.wait(|message| {
        let params = &message["params"];
        params["uri"] == *included && params["diagnostics"][0]["code"] == "E0102"
    });
    assert_eq!(found["params"]["version"], 1);
    client.change(&uri, 2, json!([{ "text": format!("1 /outer\n{scene}") }]));
    let found = shown(&client.diagnostics(&uri, 2));
    assert_eq!(
        found,
        ["1 E0201 2:7-2:11 `addi` takes two integers, but got a real and an integer"]
    );
    client.change(&included, 2, json!([{ "text": "2 /size" }]));
    assert_eq!(shown(&client.diagnostics(&uri, 2)), [""; 0]);
    client.change(&included, 3, json!([{ "text": "]" }]));
    client.wait(|message| {
        let params = &message["params"];
        params["uri"] == *included && params["diagnostics"][0]["code"] == "E0006"
    });
    client.wait(|message| {
        let params = &message["params"];
        params["uri"] == *included && params["version"] == 3
    });
    // With what is open gone, the file on the disk counts again, and with the scene its errors go.
    client.notify("textDocument/didClose", json!({ "textDocument": { "uri": included } }));
    client.wait(|message| {
        let params = &message["params"];
        params["uri"] == *included && params["diagnostics"] == json!([])
    });
    assert_eq!(shown(&client.diagnostics(&uri, 2)), [""; 0]);
    client.change(&uri, 3, json!([{ "text": "x" }]));
    assert_eq!(client.diagnostics(&uri, 3).len(), 1);
    client.notify("textDocument/didClose", json!({ "textDocument": { "uri": uri } }));
    let told = client.wait(|message| {
        let params = &message["params"];
        params["uri"] == *uri && params["version"].is_null()
    });
    assert_eq!(told["params"]["diagnostics"], json!([]));
    assert_eq!(client.quit(), 0);
}

#[test]
fn hovers_tell_of_operators_and_names() {
    let text = "% The ball.\n{ /v /u /face v } sphere /ball\nball 2.0 uscale /big n\n{ /r r uscale } /by by n";
    let mut client = Client::new(&["-D", "n=3"]);
    client.open(URI, text);
    let mut hover = |line, character| {
        let answer = client.request("textDocument/hover", at(URI, line, character));
        answer["contents"]["value"].as_str().unwrap_or("nothing").to_owned()
    };
    assert_eq!(
        hover(2, 10),
        "```text\nuscale: object real \u{2192} object\n```\n\n\
         The object, scaled alike in all directions. A factor of 0 is an error."
    );
    assert_eq!(
        hover(1, 14),
        "```gml\n% The ball.\n/v\n```\n\na real, bound in line 2, given to surface functions"
    );
    assert_eq!(hover(2, 0), "```gml\n% The ball.\n/ball\n```\n\nan object, bound in line 2");
    assert_eq!(hover(2, 21), "`n`: an integer, bound before the program starts");
    assert_eq!(
        hover(3, 20),
        "```gml\n{ /r r uscale } /by\n```\n\n\
         a function `value value \u{2192} object`, bound in line 4"
    );
    assert_eq!(hover(2, 5), "nothing");
    assert_eq!(hover(99, 99), "`n`: an integer, bound before the program starts");
    assert_eq!(client.quit(), 0);
}

#[test]
fn a_scene_cannot_write_markdown() {
    let mut client = Client::new(&[]);
    client.open(URI, "% ``` ![](http://example.com/a.png) ````\n1 /x");
    let hover = client.request("textDocument/hover", at(URI, 1, 3));
    let expected = "`````gml\n% ``` ![](http://example.com/a.png) ````\n1 /x\n`````\n\n\
                    an integer, bound in line 2";
    assert_eq!(hover["contents"]["value"], expected);
    client.change(URI, 2, json!([{ "text": "x".repeat(5000) }]));
    let found = client.diagnostics(URI, 2);
    assert!(found[0]["message"].as_str().expect("text").len() < 500, "{found:?}");
    client.change(URI, 3, json!([{ "text": "1 \u{1b}[2J" }]));
    let message = client.diagnostics(URI, 3)[0]["message"].as_str().expect("text").to_owned();
    assert!(!message.chars().any(char::is_control), "{message:?}");
    assert_eq!(client.quit(), 0);
}

#[test]
fn bindings_are_found_and_renamed() {
    let text = "1 /x { x /y x y addi } /f x f apply { 5 /x x } apply";
    let mut client = Client::new(&[]);
    client.open(URI, text);
    let definition = client.request("textDocument/definition", at(URI, 0, 26));
    assert_eq!(range(&definition["range"]), "0:3-0:4");
    let mut params = at(URI, 0, 3);
    params["context"] = json!({ "includeDeclaration": true });
    let references = client.request("textDocument/references", params);
    let ranges = |list: &Value| -> Vec<String> {
        list.as_array().expect("a list").iter().map(|item| range(&item["range"])).collect()
    };
    assert_eq!(ranges(&references), ["0:3-0:4", "0:7-0:8", "0:12-0:13", "0:26-0:27"]);
    let highlights = client.request("textDocument/documentHighlight", at(URI, 0, 43));
    assert_eq!(ranges(&highlights), ["0:41-0:42", "0:43-0:44"]);
    let prepared = client.request("textDocument/prepareRename", at(URI, 0, 2));
    assert_eq!(
        (range(&prepared["range"]), &prepared["placeholder"]),
        ("0:3-0:4".into(), &json!("x"))
    );
    assert_eq!(client.request("textDocument/prepareRename", at(URI, 0, 31)), Value::Null);
    let mut rename = |character, name: &str| {
        let mut params = at(URI, 0, character);
        params["newName"] = json!(name);
        let edits = client.try_request("textDocument/rename", params)?;
        Ok::<_, String>(ranges(&edits["changes"][URI]))
    };
    assert_eq!(rename(7, "z").expect("done"), ["0:7-0:8", "0:12-0:13", "0:26-0:27", "0:3-0:4"]);
    let refusals = [
        (7, "addi", "-32803: `addi` cannot be bound: it is the name of an operator"),
        (7, "true", "-32803: `true` cannot be bound: it is a boolean"),
        (7, "y", "-32803: `x` in line 1 would become another `y`, bound in line 1"),
        (14, "x", "-32803: `x` in line 1 would become another `x`, bound in line 1"),
        (0, "z", "-32803: no name that is bound stands here"),
    ];
    for (character, name, expected) in refusals {
        assert_eq!(rename(character, name), Err(expected.to_owned()), "{name}");
    }
    let odd =
        "-32803: `2` cannot be bound: an identifier is a letter, then letters, digits, `-` and `_`";
    assert_eq!(rename(7, "2"), Err(odd.to_owned()));
    assert_eq!(client.quit(), 0);
}

#[test]
fn symbols_and_completions() {
    let text = "{ /n n } /f [ 1 ] /list\n{ /inner 3 /three  } /g\n\"a\" /s % ";
    let mut client = Client::new(&[]);
    client.open(URI, text);
    let document = json!({ "textDocument": { "uri": URI } });
    let symbols = client.request("textDocument/documentSymbol", document);
    let show = |symbol: &Value| {
        format!("{} {} {}", symbol["name"], symbol["detail"], range(&symbol["range"]))
    };
    let symbols: Vec<_> = symbols.as_array().expect("a list").iter().map(show).collect();
    assert_eq!(
        symbols,
        [
            "\"f\" \"function\" 0:0-0:11",
            "\"list\" \"array\" 0:12-0:23",
            "\"g\" \"function\" 1:0-1:23",
            "\"s\" \"string\" 2:0-2:6"
        ]
    );
    let mut labels = |line, character| -> Vec<String> {
        let items = client.request("textDocument/completion", at(URI, line, character));
        let items = items.as_array().expect("a list").iter();
        items.map(|item| item["label"].as_str().expect("text").to_owned()).collect()
    };
    let inside = labels(1, 18);
    assert_eq!(inside[..4], ["f", "inner", "list", "three"]);
    assert!(inside.iter().any(|label| label == "sphere") && inside.len() == 4 + 50 + 2);
    assert_eq!(labels(0, 0)[..1], ["negi"]);
    // A binder, a string, a comment.
    assert_eq!([labels(1, 4), labels(2, 1), labels(2, 9)], [const { Vec::<String>::new() }; 3]);
    assert_eq!(client.quit(), 0);
}

#[test]
fn what_is_no_request_is_refused_and_the_server_goes_on() {
    let mut client = Client::start(&["--stdio"]);
    let early = client.try_request("textDocument/hover", at(URI, 0, 0));
    assert_eq!(early.expect_err("refused"), "-32002: `initialize` comes first");
    let broken: [&[u8]; 4] = [
        b"Content-Length: 1\r\n\r\n{",
        b"Content-Length: 2\r\nX: y\r\n\r\n[]",
        b"Content-Length: 3\r\n\r\n\xff\xff\xff",
        b"content-length: 10\r\n\r\n{\"id\":\"a\"}",
    ];
    for bytes in broken {
        client.send_bytes(bytes);
        let answer = client.wait(|message| message.get("error").is_some());
        assert!(answer["error"]["code"].as_i64().expect("a code") <= -32600, "{answer}");
    }
    client.request("initialize", json!({ "capabilities": {} }));
    let mut refused = |method: &str, params: Value| {
        client.try_request(method, params).expect_err("refused")[..6].to_owned()
    };
    assert_eq!(refused("initialize", json!({})), "-32601");
    assert_eq!(refused("workspace/nothing", Value::Null), "-32601");
    assert_eq!(refused("textDocument/hover", json!({ "position": -1 })), "-32602");
    client.notify("textDocument/didOpen", json!([1, 2]));
    client.notify("textDocument/didChange", json!({ "textDocument": { "uri": URI } }));
    client.change("file:///never/opened", 2, json!([{ "text": "1" }]));
    assert_eq!(client.request("textDocument/hover", at(URI, 0, 0)), Value::Null);
    client.open("untitled:Untitled-1", "1 addi");
    assert_eq!(client.diagnostics("untitled:Untitled-1", 1).len(), 1);
    client.request("shutdown", Value::Null);
    let late = client.try_request("textDocument/hover", at(URI, 0, 0));
    assert!(late.expect_err("refused").starts_with("-32600"));
    client.notify("exit", Value::Null);
    assert_eq!(client.code().0, 0);
}

#[test]
fn it_ends_with_the_client() {
    assert_eq!(Client::new(&[]).hang_up(), (1, String::new()));
    let mut client = Client::new(&[]);
    client.notify("exit", Value::Null);
    assert_eq!(client.code().0, 1);
    let mut client = Client::new(&[]);
    client.send_bytes(b"Content-Length: 99999999999999999999\r\n\r\n");
    let (code, stderr) = client.code();
    assert_eq!(code, 2);
    assert!(stderr.contains("the standard input is no language client"), "{stderr}");
}

#[test]
fn a_runaway_scene_is_checked_within_limits_and_answers_do_not_wait_for_it() {
    let mut client = Client::new(&[]);
    client.open(URI, "{ /f f f apply } /f f f apply");
    let hover = client.request("textDocument/hover", at(URI, 0, 12));
    assert!(hover["contents"]["value"].as_str().expect("text").contains("apply"));
    client.change(URI, 2, json!([{ "text": "{ /f f f apply 1 } /f f f apply" }]));
    client.change(URI, 3, json!([{ "text": "{ /a [ a a ] dup } /f 1 addi" }]));
    let found = shown(&client.diagnostics(URI, 3));
    assert_eq!(found.len(), 2, "{found:?}");
    assert_eq!(client.quit(), 0);
}

#[test]
fn huge_and_hostile_texts_are_answered() {
    // A million words, which are too many here whatever the command line says.
    let mut client = Client::new(&["--max-words", "4000000"]);
    client.open(URI, &"1 /x x addi { ".repeat(200_000));
    assert_eq!(client.diagnostics(URI, 1)[0]["code"], "E0013");
    client.request("textDocument/documentSymbol", json!({ "textDocument": { "uri": URI } }));
    let hover = client.request("textDocument/hover", at(URI, 0, 560_002));
    assert!(hover["range"].is_object());
    let texts = ["]".repeat(100_000), "x ".repeat(300_000), "\u{0}\u{1b}[2J\u{202e}".repeat(1000)];
    for (text, version) in texts.into_iter().zip(2..) {
        client.change(URI, version, json!([{ "text": text }]));
        let found = client.diagnostics(URI, version);
        assert!((1..=101).contains(&found.len()), "{}", found.len());
    }
    client.change(URI, 9, json!([{ "text": "%".repeat((64 << 20) + 1) }]));
    assert_eq!(client.diagnostics(URI, 9)[0]["code"], "E0013");
    assert_eq!(client.request("textDocument/hover", at(URI, 0, 0)), Value::Null);
    assert_eq!(client.quit(), 0);
}
