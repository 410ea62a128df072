"use strict";
// Tables are sorted by their headings and copied as text for a spreadsheet; scrolled boxes take the keyboard; shapes
// move when they are asked to.
(() => {
  const say = (text) => { document.getElementById("said").textContent = text; };

  const key = (cell) => ("value" in cell.dataset ? Number(cell.dataset.value) : cell.textContent.trim());
  const order = (a, b) => {
    if (typeof a === "number" && typeof b === "number") return a - b;
    if (typeof a !== typeof b) return typeof a === "number" ? -1 : 1; // numbers before what has none
    return a.localeCompare(b, "en", { numeric: true });
  };

  const sort = (table, column, heading) => {
    const up = heading.getAttribute("aria-sort") !== "ascending";
    for (const other of heading.parentNode.cells) other.removeAttribute("aria-sort");
    heading.setAttribute("aria-sort", up ? "ascending" : "descending");
    const rows = [...table.tBodies[0].rows];
    rows.sort((a, b) => (up ? 1 : -1) * order(key(a.cells[column]), key(b.cells[column])));
    table.tBodies[0].append(...rows);
  };

  const asText = (table) =>
    [...table.rows].map((row) => [...row.cells].map((cell) => cell.textContent.trim()).join("\t")).join("\n");

  const copy = async (table) => {
    const text = asText(table);
    try {
      await navigator.clipboard.writeText(text);
    } catch { // pages opened from a disk may not be allowed to
      const box = document.createElement("textarea");
      box.value = text;
      document.body.append(box);
      box.select();
      document.execCommand("copy");
      box.remove();
    }
    say("The table was copied.");
  };

  for (const table of document.querySelectorAll("table")) {
    if (table.tBodies[0].rows.length < 2) continue;
    [...table.tHead.rows[0].cells].forEach((heading, column) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = heading.textContent.trim();
      button.title = "Sort by this column";
      button.addEventListener("click", () => sort(table, column, heading));
      heading.replaceChildren(button);
    });
    const tools = document.createElement("div");
    tools.className = "tools";
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = "Copy table";
    button.addEventListener("click", () => copy(table));
    tools.append(button);
    table.closest(".table").append(tools);
  }

  const reachable = () => {
    for (const box of document.querySelectorAll(".scroll")) {
      if (box.scrollWidth > box.clientWidth) {
        box.tabIndex = 0;
        box.setAttribute("role", "region");
        box.setAttribute("aria-label", box.dataset.name);
      }
    }
  };
  addEventListener("resize", reachable);
  reachable();
})();

(() => {
  const control = (tools, label, element) => {
    const box = document.createElement("label");
    box.append(label, element);
    tools.append(box);
    return element;
  };

  const slider = (tools, label, lowest, highest, value, step) => {
    const range = control(tools, label, document.createElement("input"));
    Object.assign(range, { type: "range", min: lowest, max: highest, step, value });
    return range;
  };

  // A structure in space from another side: about its vertical axis, then up or down; made smaller where it needs room.
  const seenFrom = (data, turn, height) => {
    const [low, high] = [(data.elevation * Math.PI) / 180, (height * Math.PI) / 180];
    const [middle, centre] = [data.width / 2, data.height / 2];
    const place = (points) => {
      const seen = new Float64Array((points.length / 3) * 2);
      for (let i = 0, at = 0; i < points.length; i += 3, at += 2) {
        const [x, y, out] = [points[i] - middle, centre - points[i + 1], points[i + 2]];
        const upright = Math.cos(low) * y + Math.sin(low) * out;
        const level = Math.cos(low) * out - Math.sin(low) * y;
        const nearer = Math.cos(turn) * level - Math.sin(turn) * x;
        seen[at] = Math.cos(turn) * x + Math.sin(turn) * level;
        seen[at + 1] = Math.sin(high) * nearer - Math.cos(high) * upright;
      }
      return seen;
    };
    let room = 1;
    place(data.still).forEach((value, i) => {
      room = Math.min(room, ((i % 2 ? centre : middle) - 24) / Math.max(Math.abs(value), 1));
    });
    return (points) => place(points).map((value, i) => (i % 2 ? centre : middle) + room * value);
  };

  const pathOf = (points, lengths) => {
    const parts = [];
    let at = 0;
    for (const length of lengths) {
      for (let i = 0; i < length; i += 1, at += 2) {
        parts.push(i ? "L" : "M", points[at].toFixed(1), " ", points[at + 1].toFixed(1));
      }
    }
    return parts.join("");
  };

  const dotsOf = (points, first) => {
    const parts = [];
    for (let at = 2 * first; at < points.length; at += 2) {
      parts.push("M", points[at].toFixed(1), " ", points[at + 1].toFixed(1), "h0");
    }
    return parts.join("");
  };

  for (const figure of document.querySelectorAll(".motion")) {
    const data = JSON.parse(figure.querySelector("script").textContent);
    const paths = [...figure.querySelectorAll(".layer")];
    const tools = figure.querySelector(".tools");
    const lined = data.lengths.reduce((sum, length) => sum + length, 0);
    let choice = data.choices[0];
    let time = 0; // s, of the motion itself
    let before = null; // ms, when the last picture was shown
    let playing = false;

    const play = document.createElement("button");
    play.type = "button";
    play.textContent = "Play";
    tools.append(play);
    let select = null;
    if (data.choices.length > 1) {
      select = control(tools, "Motion", document.createElement("select"));
      select.append(...data.choices.map((one, number) => new Option(one.label.replace(/\.$/, ""), number)));
    }
    const speed = slider(tools, "Slow to fast", -2, 1, 0, 0.25); // powers of two
    const scale = slider(tools, "Scale", 0.25, 3, 1, 0.05);
    const isInSpace = data.elevation !== null;
    const turn = isInSpace ? slider(tools, "Turn", -180, 180, 0, 1) : null; // degrees
    const height = isInSpace ? slider(tools, "Height", 0, 90, data.elevation, 1) : null;
    const isRecorded = data.choices.some((one) => one.layers.some((layer) => layer.history));
    const place = isRecorded ? slider(tools, "Time", 0, 1, 0, 0.001) : null;

    const lasting = () => Math.max(...choice.layers.map((layer) => (layer.history ? layer.history.length - 1 : 0)));

    const factorsOf = (layer) => {
      if (!layer.history) return [Math.cos((2 * Math.PI * time) / choice.seconds)];
      const at = Math.min(time / choice.seconds, layer.history.length - 1);
      const low = Math.floor(at);
      const high = Math.min(low + 1, layer.history.length - 1);
      return layer.history[low].map((value, part) => value + (at - low) * (layer.history[high][part] - value));
    };

    const draw = () => {
      const size = Number(scale.value);
      const onPage = isInSpace
        ? seenFrom(data, (Number(turn.value) * Math.PI) / 180, Number(height.value))
        : (points) => points;
      if (isInSpace) figure.querySelector("path.still").setAttribute("d", pathOf(onPage(data.still), data.lengths));
      for (const path of paths) {
        const layer = choice.layers.find((one) => one.name === path.dataset.name);
        if (!layer) {
          path.setAttribute("d", "");
          continue;
        }
        const points = Float64Array.from(data.still);
        factorsOf(layer).forEach((factor, part) => {
          const shape = layer.shapes[part];
          for (let i = 0; i < shape.length; i += 1) points[i] += size * factor * shape[i];
        });
        const seen = onPage(points);
        path.setAttribute("d", layer.dots ? dotsOf(seen, lined) : pathOf(seen, data.lengths));
      }
      if (place) place.value = time / choice.seconds / Math.max(lasting(), 1);
    };

    const step = (now) => {
      if (!playing) return;
      if (before !== null) time += ((now - before) / 1000 / choice.slowed) * 2 ** Number(speed.value);
      before = now;
      if (lasting() && time > lasting() * choice.seconds) time = 0;
      draw();
      requestAnimationFrame(step);
    };

    play.addEventListener("click", () => {
      playing = !playing;
      before = null;
      play.textContent = playing ? "Pause" : "Play";
      if (playing) requestAnimationFrame(step);
    });
    scale.addEventListener("input", draw);
    if (isInSpace) {
      const svg = figure.querySelector("svg");
      svg.classList.add("turns");
      svg.addEventListener("pointermove", (event) => {
        if (!event.buttons) return;
        turn.value = ((Number(turn.value) + event.movementX / 2 + 540) % 360) - 180;
        height.value = Number(height.value) + event.movementY / 2;
        draw();
      });
      svg.addEventListener("pointerdown", (event) => svg.setPointerCapture(event.pointerId));
      for (const range of [turn, height]) range.addEventListener("input", draw);
    }
    if (place) {
      place.addEventListener("input", () => {
        time = Number(place.value) * lasting() * choice.seconds;
        draw();
      });
    }
    if (select) {
      select.addEventListener("change", () => {
        choice = data.choices[select.value];
        time = 0;
        figure.querySelector(".label").textContent = choice.label;
        draw();
      });
    }
  }
})();
