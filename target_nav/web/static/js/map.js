// The odometry frame from above: the way driven, the robot, where the target is believed to be. x is up.

import { $, FONT, Pad, colors, setClass, setText } from "./dom.js";
import { points, robot } from "./radar.js";

const LEAST_M = 2.4;

export function mountMap(store) {
  const pad = new Pad($("map"));
  const panel = $("map").closest(".panel");

  store.onDraw(() => {
    const live = store.live.map;
    if ((!live && !store.past?.path_m) || pad.width < 40) return;
    const view = store.past?.path_m ? store.past : live;
    const pose = store.past ? store.past.sections.pose : live.pose;
    const bounds = store.past?.path_m ? store.past.bounds : live;
    const context = pad.begin();
    const [spanX, spanY] = [Math.max(bounds.x_max_m - bounds.x_min_m, LEAST_M), Math.max(bounds.y_max_m - bounds.y_min_m, LEAST_M)];
    const scale = Math.min(pad.height / spanX, pad.width / spanY);
    const [midX, midY] = [(bounds.x_min_m + bounds.x_max_m) / 2, (bounds.y_min_m + bounds.y_max_m) / 2];
    const at = (x, y) => [pad.width / 2 - (y - midY) * scale, pad.height / 2 - (x - midX) * scale];

    grid(context, pad, at, midX, midY, scale);
    context.fillStyle = colors.grey;
    if (!store.past) points(live.obstacles_m, (x, y) => {
      const [u, v] = at(x, y);
      context.fillRect(u - 1.5, v - 1.5, 3, 3);
    });
    context.beginPath();
    points(view.path_m, (x, y) => context.lineTo(...at(x, y)));
    context.strokeStyle = colors.blue;
    context.lineWidth = 2.5;
    context.lineJoin = "round";
    context.stroke();
    const ellipse = store.past ? null : live.target;
    if (ellipse) {
      const [u, v] = at(ellipse.x_m, ellipse.y_m);
      context.strokeStyle = colors.orange;
      context.beginPath();
      context.ellipse(u, v, Math.max(ellipse.major_m * scale, 5), Math.max(ellipse.minor_m * scale, 5), -ellipse.angle_rad - Math.PI / 2, 0, 2 * Math.PI);
      context.stroke();
      context.fillStyle = colors.orange;
      context.fillRect(u - 2, v - 2, 4, 4);
    }
    context.save();
    context.translate(...at(pose.x_m, pose.y_m));
    context.rotate(-pose.yaw_rad);
    const body = store.shown.radar?.body ?? { front_m: 0.15, rear_m: 0.15, half_width_m: 0.14 };
    robot(context, body, Math.max(scale, 40), colors.text);
    context.restore();

    setClass(panel, "stale", !store.past && !live.fresh);
    setText($("map-age"), store.past || !live ? "" : `${live.driven_m.toFixed(1)} m driven`);
    setText($("map-excuse"), store.past ? "" : live.message);
  });
}

function grid(context, pad, at, midX, midY, scale) {
  const step = scale > 160 ? 0.5 : scale > 32 ? 1 : 2;
  const [halfX, halfY] = [pad.height / 2 / scale, pad.width / 2 / scale];
  context.strokeStyle = colors.line;
  context.fillStyle = colors.dim;
  context.lineWidth = 1;
  context.font = `10.5px ${FONT}`;
  for (let x = Math.ceil((midX - halfX) / step) * step; x <= midX + halfX; x += step) line(context, at(x, midY - halfY), at(x, midY + halfY), x === 0);
  for (let y = Math.ceil((midY - halfY) / step) * step; y <= midY + halfY; y += step) line(context, at(midX - halfX, y), at(midX + halfX, y), y === 0);
  context.fillText(`grid ${step} m`, 6, pad.height - 6);
}

function line(context, from, to, axis) {
  context.globalAlpha = axis ? 1 : 0.55;
  context.beginPath();
  context.moveTo(...from);
  context.lineTo(...to);
  context.stroke();
  context.globalAlpha = 1;
}
