// The world round the robot as it stands now, its nose up: LiDAR, obstacles as VFH sees them, the target, the chosen way.

import { $, FONT, Pad, age, colors, degrees, setClass, setText } from "./dom.js";

const UNIT = 1 / 200;
const RANGES = [1.5, 3, 5, 8, 12];

export function points(flat, each) {
  for (let i = 0; i + 1 < flat.length; i += 2) each(flat[i] * UNIT, flat[i + 1] * UNIT);
}

// A robot seen from above, at the origin of the context, nose along +x of base_link (up on the screen).
export function robot(context, body, scale, color) {
  const [front, rear, half] = [body.front_m * scale, body.rear_m * scale, body.half_width_m * scale];
  context.beginPath();
  context.roundRect(-half, -front, 2 * half, front + rear, Math.min(5, half / 2));
  context.fillStyle = color;
  context.globalAlpha = 0.28;
  context.fill();
  context.globalAlpha = 1;
  context.strokeStyle = color;
  context.lineWidth = 2;
  context.stroke();
  context.beginPath();
  context.moveTo(0, -front * 0.75);
  context.lineTo(half * 0.55, front * 0.1);
  context.lineTo(-half * 0.55, front * 0.1);
  context.closePath();
  context.fillStyle = color;
  context.fill();
}

export function mountRadar(store) {
  const pad = new Pad($("radar"));
  const panel = $("radar").closest(".panel");
  let zoom = 1;
  $("radar").addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom = Math.min(Math.max(zoom + Math.sign(event.deltaY), 0), RANGES.length - 1);
    store.touch();
  }, { passive: false });
  $("radar").addEventListener("click", () => {
    zoom = (zoom + 1) % RANGES.length;
    store.touch();
  });

  store.onDraw(() => {
    const view = store.shown.radar;
    if (!view || pad.width < 40) return;
    const context = pad.begin();
    const range = RANGES[zoom];
    const scale = (Math.min(pad.width, pad.height) / 2 - 6) / range;
    const at = (x, y) => [-y * scale, -x * scale];
    context.save();
    context.translate(pad.width / 2, pad.height / 2);

    context.strokeStyle = colors.line;
    context.fillStyle = colors.dim;
    context.lineWidth = 1;
    context.font = `11px ${FONT}`;
    const step = range > 6 ? 2 : range > 2 ? 1 : 0.5;
    for (let r = step; r <= range * 1.6; r += step) {
      context.beginPath();
      context.arc(0, 0, r * scale, 0, 2 * Math.PI);
      context.stroke();
      if (r <= range) context.fillText(`${r} m`, 4, -r * scale + 12);
    }

    if (view.room_m.length > 4 && view.avoid_fresh) {
      context.beginPath();
      points(view.room_m, (x, y) => context.lineTo(...at(x, y)));
      context.closePath();
      context.fillStyle = colors.green;
      context.globalAlpha = 0.1;
      context.fill();
      context.globalAlpha = 1;
    }
    context.fillStyle = colors.grey;
    if (view.avoid_fresh) points(view.obstacles_m, (x, y) => {
      const [u, v] = at(x, y);
      context.fillRect(u - 2.5, v - 2.5, 5, 5);
    });
    context.fillStyle = view.points_fresh || store.past ? colors.blue : colors.grey;
    points(view.points_m, (x, y) => {
      const [u, v] = at(x, y);
      context.fillRect(u - 1.25, v - 1.25, 2.5, 2.5);
    });

    if (view.direction_rad !== null && view.avoid_fresh) {
      const length = Math.min(Math.max(view.free_ahead_m, 0.4), range * 0.9);
      context.beginPath();
      context.moveTo(0, 0);
      context.lineTo(...at(length * Math.cos(view.direction_rad), length * Math.sin(view.direction_rad)));
      context.strokeStyle = colors.green;
      context.lineWidth = 3;
      context.setLineDash([8, 5]);
      context.stroke();
      context.setLineDash([]);
    }
    robot(context, view.body, scale, colors.text);
    if (view.target) target(context, view.target, at, scale);
    context.restore();

    setClass(panel, "stale", !store.past && !view.fresh);
    setText($("radar-age"), view.target
      ? `target ${view.target.range_m.toFixed(2)} m, ${degrees(view.target.bearing_rad).toFixed(0)}°` : store.past ? "" : `scan ${age(view.points_age_s)} old`);
    setText($("radar-excuse"), store.past ? "" : view.message);
  });
}

function target(context, view, at, scale) {
  const ellipse = view.ellipse;
  const [u, v] = at(ellipse.x_m, ellipse.y_m);
  context.strokeStyle = colors.orange;
  context.fillStyle = colors.orange;
  context.lineWidth = 2;
  context.setLineDash(view.confirmed ? [] : [4, 4]);
  context.beginPath();
  // base_link's x is up and its y to the left, so an angle turns the other way round on the screen
  context.ellipse(u, v, Math.max(ellipse.major_m * scale, 5), Math.max(ellipse.minor_m * scale, 5), -ellipse.angle_rad - Math.PI / 2, 0, 2 * Math.PI);
  context.stroke();
  context.setLineDash([]);
  context.beginPath();
  context.moveTo(u - 9, v);
  context.lineTo(u + 9, v);
  context.moveTo(u, v - 9);
  context.lineTo(u, v + 9);
  context.stroke();
}
