// Page of a benchmark report: scenes and episodes to choose from, and the player. `#SCENE/INDEX/SECONDS` is an address
// in it.

const data = JSON.parse(document.getElementById("data").textContent);
const element = (name) => document.getElementById(name);
const state = { scene: data.scenes[0], episode: data.scenes[0].episodes[0], player: null };

function make(kind, text, style) {
  const made = document.createElement(kind);
  if (text !== undefined) made.textContent = text;
  if (style) made.className = style;
  return made;
}

/** The canvas has the shape of its scene, and a pixel of its own for each of the screen. */
function fit() {
  const canvas = element("canvas");
  const width = canvas.parentElement.clientWidth;
  const { min, max } = state.scene;
  const height = Math.min((width * (max[1] - min[1])) / (max[0] - min[0]), 0.85 * window.innerHeight);
  const ratio = window.devicePixelRatio || 1;
  canvas.style.height = `${height}px`;
  [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (state.player) {
    state.player.ratio = ratio;
    state.player.draw();
  }
}

function showTime(seconds, playing) {
  element("time").value = seconds;
  element("clock").textContent = `${seconds.toFixed(1)} / ${durationOf(state.episode).toFixed(1)} s`;
  element("play").textContent = playing ? "Pause" : "Play";
}

function showScene(scene) {
  state.scene = scene;
  state.player?.pause();
  state.player = new EpisodePlayer(element("canvas"), scene, { speed: Number(element("speed").value), onTime: showTime });
  element("scene").value = data.scenes.indexOf(scene);
  element("episodes").replaceChildren(...scene.episodes.map(row));
  fit();
}

/** A line of the list of episodes. */
function row(episode) {
  const button = make("button");
  const mark = { true: ["✓", "good"], false: ["✗", "bad"] }[episode.success] ?? ["•", ""];
  button.append(make("span", mark[0], mark[1]), make("span", `#${episode.index} ${episode.about}`), make("small", episode.brief));
  button.addEventListener("click", () => showEpisode(episode));
  const line = make("li");
  line.append(button);
  return line;
}

function showEpisode(episode) {
  state.episode = episode;
  element("time").max = durationOf(episode);
  element("failure").textContent = episode.failure;
  element("metrics").replaceChildren(
    ...episode.metrics.flatMap(([name, value]) => [make("dt", name), make("dd", value)]),
  );
  [...element("episodes").querySelectorAll("button")].forEach((button, i) => {
    button.setAttribute("aria-pressed", state.scene.episodes[i] === episode);
  });
  state.player.show(episode, state.scene.episodes);
  history.replaceState(null, "", `#${encodeURIComponent(state.scene.name)}/${episode.index}`);
}

/** To where the address points, if it points into this page. */
function followAddress() {
  const [name, index, seconds] = location.hash.slice(1).split("/").map(decodeURIComponent);
  const scene = data.scenes.find((one) => one.name === name) ?? data.scenes[0];
  showScene(scene);
  showEpisode(scene.episodes.find((one) => String(one.index) === index) ?? scene.episodes[0]);
  if (Number(seconds) > 0) state.player.seek(Number(seconds));
}

const toggle = () => (state.player.playing ? state.player.pause() : state.player.play());
element("scene").replaceChildren(...data.scenes.map((scene, i) => new Option(scene.name, i)));
element("scene").addEventListener("change", (event) => {
  showScene(data.scenes[event.target.value]);
  showEpisode(state.scene.episodes[0]);
});
element("speed").addEventListener("change", (event) => { state.player.speed = Number(event.target.value); });
element("play").addEventListener("click", toggle);
element("time").addEventListener("input", (event) => {
  const seconds = Number(event.target.value); // before `pause` sets it back to where the player is
  state.player.pause();
  state.player.seek(seconds);
});
document.addEventListener("keydown", (event) => {
  if (event.key !== " " || event.target !== document.body) return;
  event.preventDefault();
  toggle();
});
window.addEventListener("resize", fit);
window.addEventListener("hashchange", followAddress);
followAddress();
