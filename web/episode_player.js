// Player of benchmark episodes on a canvas: the scene from above, the robot's trajectory, and the robot on it.
//
//   const player = new EpisodePlayer(canvas, scene);   // scene: {min, max, walls, furniture, rooms}, polygons in metres
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
  const scale = Math.max(1e-3, Math.min((width - 2 * margin) / size[0], (height - 2 * margin) / size[1])); // also if hidden
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

const COLORS = {
  floor: "#ffffff",
  furniture: "#dfd9cc",
  walls: "#3d4657",
  room: "#6b7485",
  good: "#17804a",
  bad: "#c4313c",
  driven: "#1f5fd0",
  ahead: "#8fb4f2",
  robot: "#f47b20",
  edge: "#ffffff",
};

/** Draws one scene, and any episode in it. */
export class EpisodePlayer {
  constructor(canvas, scene, { speed = 4, ratio = 1, onTime = () => {} } = {}) {
    this.canvas = canvas;
    this.scene = scene;
    this.speed = speed; // seconds of robot time in one of the wall
    this.ratio = ratio; // pixels of the canvas in one of the page
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
      this.seek(this.seconds + (this.speed * Math.max(0, now - last)) / 1000);
      last = now;
      if (this.seconds >= durationOf(this.episode)) this.pause();
      else requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  pause() {
    this.playing = false;
    if (this.episode) this.onTime(this.seconds, this.playing);
  }

  /** To a time [s] of the episode. */
  seek(seconds) {
    this.seconds = this.episode ? Math.min(Math.max(seconds, 0), durationOf(this.episode)) : 0;
    this.draw();
    if (this.episode) this.onTime(this.seconds, this.playing);
  }

  draw() {
    const context = this.canvas.getContext("2d");
    const view = viewOf(this.scene, this.canvas.width, this.canvas.height, 12 * this.ratio);
    context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    context.lineJoin = context.lineCap = "round";
    this.drawScene(context, view);
    for (const other of this.others) {
      if (other === this.episode) continue;
      context.globalAlpha = 0.45;
      const dashes = other.success === false ? [5, 4] : [];
      line(context, view, other.trajectory, other.success === false ? COLORS.bad : COLORS.good, 1.5 * this.ratio, dashes);
      context.globalAlpha = 1;
    }
    if (this.episode !== null) this.drawEpisode(context, view);
  }

  drawScene(context, view) {
    const [left, top] = view.toPixels([this.scene.min[0], this.scene.max[1]]);
    const [right, bottom] = view.toPixels([this.scene.max[0], this.scene.min[1]]);
    context.fillStyle = COLORS.floor;
    context.fillRect(left, top, right - left, bottom - top);
    for (const polygon of this.scene.furniture) fill(context, view, polygon, COLORS.furniture);
    for (const polygon of this.scene.walls) fill(context, view, polygon, COLORS.walls);
    context.fillStyle = COLORS.room;
    context.textAlign = "center";
    context.font = `${12 * this.ratio}px system-ui, sans-serif`;
    for (const room of this.scene.rooms ?? []) {
      const width = view.scale * (room.max[0] - room.min[0]);
      if (width < 7 * room.name.length * this.ratio) continue; // no room for its name
      const [x, y] = view.toPixels([(room.min[0] + room.max[0]) / 2, room.max[1]]);
      this.write(context, room.name, x, y + 22 * this.ratio);
    }
    this.drawScale(context, view);
  }

  /** A bar of a whole number of metres, below on the right. */
  drawScale(context, view) {
    const metres = [1, 2, 5, 10].find((one) => one * view.scale > 50 * this.ratio) ?? 20;
    const [right, bottom] = view.toPixels([this.scene.max[0], this.scene.min[1]]);
    const [end, y] = [right - 24 * this.ratio, bottom - 24 * this.ratio];
    const start = end - metres * view.scale;
    for (const [style, edge] of [[COLORS.edge, 2 * this.ratio], [COLORS.walls, 0]]) {
      context.fillStyle = style;
      context.fillRect(start - edge, y - 2 * this.ratio - edge, end - start + 2 * edge, 4 * this.ratio + 2 * edge);
    }
    this.write(context, `${metres} m`, (start + end) / 2, y - 8 * this.ratio);
  }

  /** A text with an edge, legible over furniture. */
  write(context, text, x, y) {
    context.strokeStyle = COLORS.edge;
    context.lineWidth = 4 * this.ratio;
    context.strokeText(text, x, y);
    context.fillText(text, x, y);
  }

  drawEpisode(context, view) {
    const { trajectory, period, goal } = this.episode;
    if (goal) {
      dot(context, view, goal, 0.5 * view.scale, `${COLORS.good}33`);
      dot(context, view, goal, 4 * this.ratio, COLORS.good);
    }
    const pose = poseAt(trajectory, period, this.seconds);
    if (pose === null) return;
    const driven = [...trajectory.slice(0, Math.floor(this.seconds / period) + 1), pose];
    line(context, view, trajectory, COLORS.edge, 6 * this.ratio);
    line(context, view, trajectory, COLORS.ahead, 3 * this.ratio);
    line(context, view, driven, COLORS.driven, 3 * this.ratio);
    dot(context, view, trajectory[0], 6 * this.ratio, COLORS.edge);
    dot(context, view, trajectory[0], 4 * this.ratio, COLORS.driven);
    this.drawRobot(context, view, pose);
  }

  drawRobot(context, view, pose) {
    const radius = Math.max(this.episode.radius ?? 0.17, (7 * this.ratio) / view.scale);
    dot(context, view, pose, radius * view.scale + 1.5 * this.ratio, COLORS.edge);
    dot(context, view, pose, radius * view.scale, COLORS.robot);
    const corner = (angle, share) => [
      pose[0] + share * radius * Math.cos(pose[2] + angle),
      pose[1] + share * radius * Math.sin(pose[2] + angle),
    ];
    fill(context, view, [corner(0, 0.85), corner(2.4, 0.7), corner(Math.PI, 0.2), corner(-2.4, 0.7)], COLORS.edge);
  }
}

function fill(context, view, polygon, style) {
  context.fillStyle = style;
  context.beginPath();
  for (const point of polygon) context.lineTo(...view.toPixels(point));
  context.closePath();
  context.fill();
}

function line(context, view, points, style, width, dashes = []) {
  context.strokeStyle = style;
  context.lineWidth = width;
  context.setLineDash(dashes);
  context.beginPath();
  for (const point of points) context.lineTo(...view.toPixels(point));
  context.stroke();
  context.setLineDash([]);
}

function dot(context, view, point, radius, style) {
  const [x, y] = view.toPixels(point);
  context.fillStyle = style;
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.fill();
}
