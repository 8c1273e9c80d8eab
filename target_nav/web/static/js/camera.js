// The camera's picture with the boxes over it.

import { $, FONT, Pad, age, colors, setClass, setText } from "./dom.js";

export function mountCamera(store, link) {
  const pad = new Pad($("camera"));
  const panel = $("camera").closest(".panel");
  let pictureAge = null;
  let pictureAt = 0;

  link.addEventListener("picture", async (event) => {
    pictureAge = event.detail.age_s;
    pictureAt = performance.now();
    try {
      const image = await createImageBitmap(event.detail.blob);
      store.image?.close?.();
      store.image = image;
    } catch {
      store.image = null;
    }
    store.touch();
  });

  function box(context, each, scale) {
    const [x, y] = [each.left_px * scale, each.top_px * scale];
    const [w, t] = [(each.right_px - each.left_px) * scale, (each.bottom_px - each.top_px) * scale];
    context.lineWidth = each.is_target ? 3 : 1.5;
    context.strokeStyle = each.is_target ? "#f0a92b" : each.confirmed ? "#56b4e9" : "#c9d2da";
    context.setLineDash(each.confirmed ? [] : [5, 4]);
    context.strokeRect(x, y, w, t);
    context.setLineDash([]);
    context.font = `600 13px ${FONT}`;
    const label = `${each.is_target ? "◎ " : ""}${each.label}`;
    const width = context.measureText(label).width + 12;
    const left = Math.max(2, Math.min(x - 1, store.cameraWidth - width - 2));
    const top = y > 24 ? y - 22 : y + t + 24 < store.cameraHeight ? y + t + 3 : Math.max(y, 0) + 4;
    context.fillStyle = "rgb(12 16 20 / .82)";
    context.beginPath();
    context.roundRect(left, top, width, 20, 5);
    context.fill();
    context.fillStyle = context.strokeStyle;
    context.fillText(label, left + 6, top + 14.5);
  }

  store.onDraw(() => {
    const view = store.shown.camera;
    if (!view || pad.width < 40) return;
    const context = pad.begin();
    const scale = Math.min(pad.width / view.width_px, pad.height / view.height_px);
    const [w, t] = [view.width_px * scale, view.height_px * scale];
    [store.cameraWidth, store.cameraHeight] = [w, t];
    context.save();
    context.translate((pad.width - w) / 2, (pad.height - t) / 2);
    context.fillStyle = colors.raised;
    context.beginPath();
    context.roundRect(0, 0, w, t, 6);
    context.fill();
    context.clip();
    const image = store.shownImage;
    if (image) context.drawImage(image, 0, 0, w, t);
    if (view.boxes_fresh || store.past) for (const each of view.boxes) box(context, each, scale);
    context.restore();
    const stale = !store.past && !view.fresh;
    setClass(panel, "stale", stale);
    const shownAge = pictureAge === null ? view.age_s : pictureAge + (performance.now() - pictureAt) / 1000;
    setText($("camera-age"), store.past ? "" : view.fresh ? `${age(shownAge)} old` : age(view.age_s));
    setText($("camera-excuse"), store.past ? (image ? "" : "no picture kept of this moment") : view.message || view.boxes_message);
  });
}
