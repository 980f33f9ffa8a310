// Player of benchmark episodes on a canvas: the scene from above, the robot's trajectory, and the robot on it.
//
//   const player = new EpisodePlayer(canvas, scene);   // scene: {min, max, walls, furniture}, polygons in metres
//   player.show({trajectory, period, goal, radius});   // poses [x, y, theta] every `period` seconds
//   player.play();
//
// No dependencies. Positions are in metres in the scene's frame, x right and y up; angles counter-clockwise in radians.

/** The pose at a time [s], between the two nearest ones. */
export function poseAt(trajectory, period, seconds) {
  if (trajectory.length === 0) return null;
  const place = Math.min(Math.max(seconds / period, 0), trajectory.length - 1);
  const before = trajectory[Math.floor(place)];
  const after = trajectory[Math.min(Math.floor(place) + 1, trajectory.length - 1)];
  const share = place - Math.floor(place);
  const turn = Math.atan2(Math.sin(after[2] - before[2]), Math.cos(after[2] - before[2]));
  return [
    before[0] + share * (after[0] - before[0]),
    before[1] + share * (after[1] - before[1]),
    before[2] + share * turn,
  ];
}

/** How metres become pixels: all of the scene fits, with a margin, and y points up. */
export function viewOf(scene, width, height, margin = 12) {
  const size = [scene.max[0] - scene.min[0], scene.max[1] - scene.min[1]];
  const scale = Math.min((width - 2 * margin) / size[0], (height - 2 * margin) / size[1]);
  const left = (width - scale * size[0]) / 2;
  const top = (height - scale * size[1]) / 2;
  return {
    scale,
    toPixels: ([x, y]) => [left + scale * (x - scene.min[0]), top + scale * (scene.max[1] - y)],
  };
}

/** How long an episode is [s]. */
export function durationOf(episode) {
  return Math.max(0, episode.trajectory.length - 1) * episode.period;
}

/** Draws one scene, and any episode in it. */
export class EpisodePlayer {
  constructor(canvas, scene, { speed = 4, onTime = () => {} } = {}) {
    this.canvas = canvas;
    this.scene = scene;
    this.speed = speed; // seconds of robot time in one of the wall
    this.onTime = onTime;
    this.episode = null;
    this.others = [];
    this.seconds = 0;
    this.playing = false;
    this.draw();
  }

  /** An episode to play; `others` are drawn thinly below it. */
  show(episode, others = []) {
    this.pause();
    this.episode = episode;
    this.others = others;
    this.seek(0);
  }

  play() {
    if (this.playing || this.episode === null) return;
    if (this.seconds >= durationOf(this.episode)) this.seconds = 0;
    this.playing = true;
    let last = performance.now();
    const frame = (now) => {
      if (!this.playing) return;
      this.seek(this.seconds + (this.speed * (now - last)) / 1000);
      last = now;
      if (this.seconds >= durationOf(this.episode)) this.pause();
      else requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  pause() {
    this.playing = false;
    this.onTime(this.seconds, this.playing);
  }

  /** To a time [s] of the episode. */
  seek(seconds) {
    this.seconds = this.episode ? Math.min(Math.max(seconds, 0), durationOf(this.episode)) : 0;
    this.draw();
    this.onTime(this.seconds, this.playing);
  }

  draw() {
    const context = this.canvas.getContext("2d");
    const view = viewOf(this.scene, this.canvas.width, this.canvas.height);
    context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    for (const polygon of this.scene.furniture) fill(context, view, polygon, "#d9d3c7");
    for (const polygon of this.scene.walls) fill(context, view, polygon, "#4c566a");
    for (const other of this.others) line(context, view, other.trajectory, other.success ? "#2e9e5c55" : "#d0384655", 1);
    if (this.episode === null) return;
    line(context, view, this.episode.trajectory, "#3474db", 2);
    if (this.episode.goal) dot(context, view, this.episode.goal, Math.max(4, 0.5 * view.scale), "#2e9e5c66");
    dot(context, view, this.episode.trajectory[0] ?? [NaN, NaN], 4, "#3474db");
    this.drawRobot(context, view);
  }

  drawRobot(context, view) {
    const pose = poseAt(this.episode.trajectory, this.episode.period, this.seconds);
    if (pose === null) return;
    const radius = this.episode.radius ?? 0.17;
    dot(context, view, pose, Math.max(5, radius * view.scale), "#ff7a2e");
    const nose = [pose[0] + 2 * radius * Math.cos(pose[2]), pose[1] + 2 * radius * Math.sin(pose[2])];
    line(context, view, [pose, nose], "#7a3208", 2);
  }
}

function fill(context, view, polygon, style) {
  context.fillStyle = style;
  context.beginPath();
  for (const point of polygon) context.lineTo(...view.toPixels(point));
  context.closePath();
  context.fill();
}

function line(context, view, points, style, width) {
  context.strokeStyle = style;
  context.lineWidth = width;
  context.beginPath();
  for (const point of points) context.lineTo(...view.toPixels(point));
  context.stroke();
}

function dot(context, view, point, radius, style) {
  const [x, y] = view.toPixels(point);
  context.fillStyle = style;
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.fill();
}
