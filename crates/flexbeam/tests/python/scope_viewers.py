"""Several viewers, and those who may not steer: hand-over, no token, a wrong one, pages from elsewhere."""

import http.server
import threading

from playwright.sync_api import expect
from scenario import scenario

# A greeting and then everything that could change a run, over a connection of one's own. Returns the replies.
TRY_ALL = """async token => {
    const socket = new WebSocket(`ws://${location.host}/live`), replies = {};
    await new Promise((done, failed) => { socket.onopen = done; socket.onerror = failed; });
    socket.send(JSON.stringify({type: "enter", protocol: 1, token, name: "stranger", key: "k", after: null}));
    const wishes = [
        {type: "take"}, {type: "set", values: {"reference.amplitude_rad": 1.0}}, {type: "do", request: {do: "start"}},
        {type: "do", request: {do: "stop"}}, {type: "do", request: {do: "emergency"}}, {type: "release"},
        {type: "give", to: 1, yes: true}, {type: "save", screen: {scope: [], panel: []}},
    ];
    const answered = new Promise(done => {
        socket.onmessage = ({data}) => {
            const message = typeof data === "string" ? JSON.parse(data) : {};
            if (message.type === "reply") replies[message.id] = message.ok;
            if (Object.keys(replies).length === wishes.length) done();
        };
        socket.onclose = done;
    });
    wishes.forEach((wish, k) => socket.send(JSON.stringify({...wish, id: k + 1})));
    await answered;
    socket.close();
    return Object.values(replies);
}"""

# What becomes of a WebSocket, and of a plain request, from where the script runs.
REACH = """async port => {
    const socket = new WebSocket(`ws://127.0.0.1:${port}/live`);
    const opened = await new Promise(done => { socket.onopen = () => done(true); socket.onerror = () => done(false); });
    const read = await fetch(`http://127.0.0.1:${port}/`).then(answer => answer.text(), () => null);
    return {opened, read};
}"""


def nothing_changed(run):
    """The recording of a run that was only started and stopped by its holder."""
    recording = run.recording()
    assert [live["revision"] for live in recording.settings] == [0], recording.settings
    assert not recording.said("fault"), recording.events


@scenario
def without_the_token_nothing_changes(program, browser):
    run = program.run(program.controller())
    for name, url, told in [("no", run.base, "no token"), ("wrong", run.base + "#aaaaaaaaaaaaaaaaaaaaaaaaaa", "another run")]:
        stranger = browser.viewer(url)
        stranger.reads("Armed")
        stranger.goes_on()
        expect(stranger.page.get_by_role("region", name="Panel Reference")).to_contain_text(told)
        assert stranger.button("Start").is_disabled() and stranger.button("Stop").is_disabled()
        assert stranger.slider("Amplitude in °").is_disabled() and stranger.entry("Amplitude in °").is_disabled()
        stranger.page.keyboard.press("Control+.")
        expect(stranger.page.get_by_text("Emergency stop did nothing")).to_be_visible()
        replies = stranger.ask(TRY_ALL, url.partition("#")[2] or None)
        assert replies and not any(replies), replies
        mine = stranger.ask("() => window.flexbeam.connection.request({type: 'do', request: {do: 'start'}})")
        assert not mine["ok"], mine
        stranger.reads("Armed")
        stranger.shot(f"viewer_{name}_token")
        stranger.close()
    holder = browser.viewer(run.url)
    holder.press("Start")
    holder.reads("Running")
    holder.press("Stop")
    assert run.status() == 0
    nothing_changed(run)
    holder.close()


@scenario
def a_page_from_elsewhere_cannot_connect(program, browser):
    run = program.run(program.controller())

    class Elsewhere(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.end_headers()
            self.wfile.write(b"<!doctype html><title>elsewhere</title>")

        def log_message(self, *_):
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Elsewhere) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        context = browser.context()
        page = context.new_page()
        page.goto(f"http://127.0.0.1:{server.server_port}/")
        assert page.evaluate(REACH, run.port) == {"opened": False, "read": None}
        framed = page.evaluate(
            """url => new Promise(done => {
                const frame = document.createElement("iframe");
                frame.src = url;
                frame.onload = () => done(frame.contentDocument === null && frame.contentWindow.length);
                document.body.append(frame);
            })""", run.base,
        )
        assert framed in (0, False)
        assert all("flexbeam" not in (frame.title() or "") for frame in page.frames[1:]), "nor can it be framed"
        server.shutdown()
    rebound = page.goto(f"http://rebound.test:{run.port}/")
    assert rebound.status == 403, "a name that points here is not this server's"
    context.close()
    friend = browser.viewer(run.url)
    friend.reads("Armed")
    assert friend.ask(REACH, run.port)["opened"], "its own page does connect"
    friend.press("Stop")
    run.status()
    nothing_changed(run)
    friend.close()


@scenario
def control_is_asked_for_refused_and_given(program, browser):
    run = program.run(program.controller(), "--signal", "square")
    first, second = browser.viewer(run.url), browser.viewer(run.url)
    mine, theirs = "You are in control.", "is in control."
    expect(first.page.get_by_text(mine)).to_be_visible()
    assert second.button("Start").is_disabled() and second.slider("Amplitude in °").is_disabled()
    assert second.button("Stop").is_enabled(), "to stop it takes only the token"
    asked = first.page.get_by_role("alertdialog")
    second.press("Ask for control")
    expect(asked).to_contain_text("asks for control")
    first.shot("viewer_asked")
    second.shot("viewer_asks")
    first.press("Keep control")
    expect(asked).to_be_hidden()
    expect(first.page.get_by_text(mine)).to_be_visible()
    expect(second.button("Ask for control")).to_be_visible()
    assert second.button("Start").is_disabled()
    second.press("Ask for control")
    first.press("Give control")
    expect(second.page.get_by_text(mine)).to_be_visible()
    expect(first.page.get_by_role("region", name="Panel Reference")).to_contain_text(theirs)
    assert first.button("Start").is_disabled()
    second.press("Start")
    first.reads("Running")
    dragged = second.drag("Amplitude in °", 0.7)
    first.until("the other page sees it", lambda: first.reading("Amplitude in °") == dragged)
    first.press("Stop")
    assert run.status() == 0
    for viewer in [first, second]:
        viewer.reads("Stopped")
        viewer.close()


@scenario
def silence_gives_control_away(program, browser):
    run = program.run(program.controller())
    first, second = browser.viewer(run.url), browser.viewer(run.url)
    expect(first.page.get_by_text("You are in control.")).to_be_visible()
    second.press("Ask for control")
    expect(first.page.get_by_role("alertdialog")).to_be_visible()
    expect(second.page.get_by_text("You are in control.")).to_be_visible()
    expect(first.page.get_by_role("alertdialog")).to_be_hidden()
    second.press("Release control")
    first.press("Take control")
    expect(first.page.get_by_text("You are in control.")).to_be_visible()
    first.press("Stop")
    run.status()
    for viewer in [first, second]:
        viewer.close()
