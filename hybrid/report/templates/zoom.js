"use strict";
// Figures open large: wheel, drag, two fingers and keys come closer and move; what is drawn stays sharp.
(() => {
  const MOST = 60; // times as close as the whole
  const dialog = document.createElement("dialog");
  dialog.className = "large";
  dialog.setAttribute("aria-label", "Figure, enlarged");
  const tools = document.createElement("div");
  tools.className = "tools";
  const stage = document.createElement("div");
  stage.className = "stage";
  stage.tabIndex = 0;
  dialog.append(tools, stage);
  document.body.append(dialog);

  let svg = null;
  let whole = null; // [x, y, width, height] of the view box
  let view = null;
  const touching = new Map(); // pointers that are down, by their numbers

  const show = () => svg.setAttribute("viewBox", view.join(" "));
  const scaleOf = () => {
    const box = svg.getBoundingClientRect();
    return Math.max(view[2] / box.width, view[3] / box.height); // units of the drawing a pixel
  };
  const moved = (dx, dy) => {
    const scale = scaleOf();
    view[0] -= dx * scale;
    view[1] -= dy * scale;
    show();
  };
  const closer = (factor, x, y) => {
    const box = svg.getBoundingClientRect();
    const width = Math.min(Math.max(view[2] / factor, whole[2] / MOST), whole[2]);
    const times = width / view[2];
    const scale = scaleOf();
    const [right, down] = [((x ?? box.left + box.width / 2) - box.left - box.width / 2) * scale,
      ((y ?? box.top + box.height / 2) - box.top - box.height / 2) * scale];
    const middle = [view[0] + view[2] / 2 + right * (1 - times), view[1] + view[3] / 2 + down * (1 - times)];
    view = [middle[0] - width / 2, middle[1] - (view[3] * times) / 2, width, view[3] * times];
    if (width === whole[2]) view = [...whole];
    show();
  };

  const button = (text, act) => {
    const one = document.createElement("button");
    one.type = "button";
    one.textContent = text;
    one.addEventListener("click", act);
    tools.append(one);
  };
  button("Closer", () => closer(1.5));
  button("Farther", () => closer(1 / 1.5));
  button("Whole", () => { view = [...whole]; show(); });
  button("Close", () => dialog.close());

  stage.addEventListener("wheel", (event) => {
    event.preventDefault();
    closer(Math.exp(-event.deltaY / 300), event.clientX, event.clientY);
  }, { passive: false });
  stage.addEventListener("pointerdown", (event) => {
    stage.setPointerCapture(event.pointerId);
    touching.set(event.pointerId, [event.clientX, event.clientY]);
  });
  stage.addEventListener("pointermove", (event) => {
    const before = touching.get(event.pointerId);
    if (!before) return;
    const now = [event.clientX, event.clientY];
    const other = [...touching].find(([number]) => number !== event.pointerId);
    if (other) {
      const apart = (point) => Math.hypot(point[0] - other[1][0], point[1] - other[1][1]) || 1;
      closer(apart(now) / apart(before), (now[0] + other[1][0]) / 2, (now[1] + other[1][1]) / 2);
    } else {
      moved(now[0] - before[0], now[1] - before[1]);
    }
    touching.set(event.pointerId, now);
  });
  for (const name of ["pointerup", "pointercancel"]) {
    stage.addEventListener(name, (event) => touching.delete(event.pointerId));
  }
  stage.addEventListener("keydown", (event) => {
    const steps = { ArrowLeft: [60, 0], ArrowRight: [-60, 0], ArrowUp: [0, 60], ArrowDown: [0, -60] };
    if (event.key in steps) moved(...steps[event.key]);
    else if (event.key === "+" || event.key === "=") closer(1.5);
    else if (event.key === "-") closer(1 / 1.5);
    else if (event.key === "0") { view = [...whole]; show(); } else return;
    event.preventDefault();
  });
  dialog.addEventListener("close", () => {
    stage.replaceChildren();
    touching.clear();
  });

  for (const box of document.querySelectorAll(".drawing")) {
    const own = box.querySelector("svg");
    if (!own) continue;
    const bar = document.createElement("div");
    bar.className = "tools open";
    const open = document.createElement("button");
    open.type = "button";
    open.textContent = "Enlarge";
    open.addEventListener("click", () => {
      svg = own.cloneNode(true);
      whole = own.getAttribute("viewBox").split(/[ ,]+/).map(Number);
      view = [...whole];
      stage.replaceChildren(svg);
      stage.setAttribute("aria-label", box.getAttribute("aria-label"));
      dialog.showModal();
      stage.focus();
    });
    bar.append(open);
    box.closest("figure").insertBefore(bar, box.closest(".scroll").nextSibling);
  }
})();
