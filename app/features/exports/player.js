// Plays a run without a server: viser's own page draws the scene, this script moves its nodes and draws the curves.
(async () => {
  const $ = (id) => document.getElementById(id);

  // --- what was recorded: 4 bytes of length, JSON, then numbers, all of it compressed
  const text = $("duet-film").textContent.trim();
  const packed = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const buffer = await new Response(stream).arrayBuffer();
  const length = new DataView(buffer).getUint32(0, true);
  const film = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const base = Math.ceil((4 + length) / 8) * 8;
  const kinds = { i2: Int16Array, f4: Float32Array, u1: Uint8Array };
  const numbers = (a) => new kinds[a.kind](buffer, base + a.at, a.count);

  const tracks = film.tracks.map((t) => {
    let frame = 0;
    const frames = t.frames.map((gap) => {
      frame += gap;
      return frame;
    });
    return { ...t, frames, data: t.numbers ? numbers(t.numbers) : null, shown: -1 };
  });
  const last = film.frames - 1;
  const timeOf = (frame) => film.begin + frame / film.rate;

  function trackValue(track, i) {
    if (track.data === null) return track.values[i];
    const row = track.data.subarray(i * track.width, (i + 1) * track.width);
    if (track.what === "wxyz") return Array.from(row, (x) => x / 32767);
    return track.what === "position" ? Array.from(row) : row;
  }

  function message(track, i) {
    const value = trackValue(track, i);
    const name = track.node;
    const owner = "";
    if (track.what === "wxyz") return { type: "SetOrientationMessage", name, wxyz: value, owner };
    if (track.what === "position") return { type: "SetPositionMessage", name, position: value, owner };
    if (track.what === "visible") return { type: "SetSceneNodeVisibilityMessage", name, visible: value, owner };
    return { type: "SceneNodeUpdateMessage", name, updates: { [track.what]: value }, owner };
  }

  // The newest change at or before a frame.
  function place(frames, frame) {
    let low = 0;
    let high = frames.length;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (frames[middle] <= frame) low = middle;
      else high = middle;
    }
    return low;
  }

  let viser = null;
  function move(frame) {
    if (viser === null) return;
    for (const track of tracks) {
      const i = place(track.frames, frame);
      if (i === track.shown) continue;
      track.shown = i;
      viser.messageQueue.push(message(track, i));
    }
    viser.requestRender();
  }

  // --- curves
  const strips = film.panels.some((panel) => panel.rows.length);
  // A canvas wants a colour as it is, not as a pair for light and dark: an element resolves it.
  const probe = document.body.appendChild(document.createElement("i"));
  probe.hidden = true;
  const colour = (name) => {
    probe.style.color = `var(${name})`;
    return getComputedStyle(probe).color;
  };
  const plots = film.panels.map((panel, index) => {
    const figure = document.createElement("figure");
    const caption = document.createElement("figcaption");
    const title = document.createElement("b");
    title.textContent = panel.unit ? `${panel.title} [${panel.unit}]` : panel.title;
    const output = document.createElement("output");
    caption.append(title, output);
    for (const stroke of panel.strokes) {
      if (!stroke.name.length) continue;
      const item = document.createElement("span");
      const line = document.createElement("i");
      item.style.color = line.style.borderColor = stroke.colour;
      if (stroke.dash.length) line.className = stroke.dash[0] > 3 ? "dashed" : "dotted";
      item.append(line);
      for (const [part, low] of stroke.name) {
        const piece = document.createElement(low ? "sub" : "span");
        piece.textContent = part;
        item.append(piece);
      }
      caption.append(item);
    }
    const box = document.createElement("div");
    const curves = document.createElement("canvas");
    const cursor = document.createElement("canvas");
    box.append(curves, cursor);
    figure.append(caption, box);
    figure.setAttribute("role", "img");
    figure.setAttribute("aria-label", title.textContent);
    $("duet-plots").append(figure);
    const times = numbers(panel.times);
    const strokes = panel.strokes.map((s) => ({ ...s, values: numbers(s.values) }));
    const plot = { panel, times, strokes, box, curves, cursor, output, lowest: index === film.panels.length - 1 };
    box.addEventListener("pointerdown", (event) => {
      box.setPointerCapture(event.pointerId);
      grab(plot, event);
    });
    box.addEventListener("pointermove", (event) => {
      if (box.hasPointerCapture(event.pointerId)) grab(plot, event);
    });
    return plot;
  });

  function ticks(low, high, most) {
    const raw = (high - low) / Math.max(most, 1);
    const power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= raw);
    const found = [];
    for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) found.push(i * step);
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    return found.map((v) => [v, v.toFixed(digits).replace("-", "\u2212").replace(".", film.words.point)]);
  }

  function frameOf(plot) {
    const width = plot.box.clientWidth;
    const height = plot.box.clientHeight;
    const left = strips ? Math.min(130, 0.4 * width) : 44;
    const bottom = plot.lowest ? 20 : 6;
    const t0 = timeOf(0);
    const t1 = Math.max(timeOf(last), t0 + 1e-6);
    const [low, high] = plot.panel.limits;
    return {
      width,
      height,
      left,
      right: width - 6,
      top: 8,
      bottom: height - bottom,
      t0,
      t1,
      low,
      high,
      x: (t) => left + ((t - t0) / (t1 - t0)) * (width - 6 - left),
      y: (v) => height - bottom - ((v - low) / (high - low)) * (height - bottom - 4),
    };
  }

  function fresh(canvas, f) {
    const k = window.devicePixelRatio || 1;
    canvas.width = Math.round(f.width * k);
    canvas.height = Math.round(f.height * k);
    const pen = canvas.getContext("2d");
    pen.scale(k, k);
    pen.font = '11px system-ui, "Segoe UI", Roboto, "Liberation Sans", sans-serif';
    return pen;
  }

  function draw(plot) {
    plot.frame = frameOf(plot);
    const f = plot.frame;
    if (f.width < 20 || f.height < 20) return;
    const pen = fresh(plot.curves, f);
    const { panel } = plot;
    const down = panel.rows.length ? panel.rows.map((name, i) => [i, name]) : ticks(f.low, f.high, (f.bottom - f.top) / 26);
    pen.strokeStyle = colour("--line");
    pen.fillStyle = colour("--soft");
    pen.lineWidth = 1;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const [value, name] of panel.note ? [] : down) {
      const y = Math.round(f.y(value)) + 0.5;
      pen.beginPath();
      pen.moveTo(f.left, y);
      pen.lineTo(f.right, y);
      pen.stroke();
      pen.fillText(name, f.left - 5, y, f.left - 6);
    }
    pen.textAlign = "center";
    pen.textBaseline = "top";
    for (const [value, name] of ticks(f.t0, f.t1, (f.right - f.left) / 64)) {
      const x = Math.round(f.x(value)) + 0.5;
      pen.beginPath();
      pen.moveTo(x, f.top);
      pen.lineTo(x, f.bottom);
      pen.stroke();
      if (plot.lowest) pen.fillText(`${name} s`, Math.min(x, f.right - 12), f.bottom + 5);
    }
    if (panel.note) {
      pen.textBaseline = "middle";
      pen.fillText(panel.note, (f.left + f.right) / 2, (f.top + f.bottom) / 2, f.right - f.left);
    }
    pen.save();
    pen.beginPath();
    pen.rect(f.left, f.top - 2, f.right - f.left, f.bottom - f.top + 4);
    pen.clip();
    pen.lineJoin = "round";
    for (const stroke of plot.strokes) {
      pen.strokeStyle = stroke.colour;
      pen.lineWidth = stroke.width;
      pen.setLineDash(stroke.dash);
      pen.beginPath();
      let wasFinite = false;
      let previousY = 0;
      stroke.values.forEach((value, i) => {
        if (!Number.isFinite(value)) {
          wasFinite = false;
          return;
        }
        const x = f.x(plot.times[i]);
        const y = f.y(value);
        if (!wasFinite) pen.moveTo(x, y);
        else if (!stroke.steps) pen.lineTo(x, y);
        // A strip goes on until the next one begins, without a line between them.
        else {
          pen.lineTo(x, previousY);
          pen.moveTo(x, y);
        }
        wasFinite = true;
        previousY = y;
      });
      pen.stroke();
    }
    pen.restore();
    if (film.mark) mark(plot, pen);
  }

  // The moment worth a look: a dashed line with its name, on the side where there is room.
  function mark(plot, pen) {
    const f = plot.frame;
    const x = f.x(film.mark.time);
    const late = x > (f.left + f.right) / 2;
    pen.strokeStyle = pen.fillStyle = colour("--soft");
    pen.lineWidth = 1;
    pen.setLineDash([4, 3]);
    pen.beginPath();
    pen.moveTo(x, f.top);
    pen.lineTo(x, f.bottom);
    pen.stroke();
    pen.setLineDash([]);
    if (plot !== plots[0]) return;
    pen.textAlign = late ? "right" : "left";
    pen.textBaseline = "top";
    pen.fillText(film.mark.name, x + (late ? -5 : 5), f.top);
  }

  function point(plot, time) {
    const f = plot.frame;
    if (!f || f.width < 20 || f.height < 20) return;
    const pen = fresh(plot.cursor, f);
    const x = f.x(time);
    const i = place(plot.times, time + 1e-6);
    pen.strokeStyle = colour("--ink");
    pen.lineWidth = 1;
    pen.beginPath();
    pen.moveTo(x, f.top);
    pen.lineTo(x, f.bottom);
    pen.stroke();
    for (const stroke of plot.strokes) {
      const value = stroke.values[i];
      if (!Number.isFinite(value) || value < f.low || value > f.high) continue;
      pen.fillStyle = stroke.colour;
      pen.beginPath();
      pen.arc(x, f.y(value), 3, 0, 7);
      pen.fill();
    }
    const first = plot.strokes.length ? plot.strokes[0].values[i] : NaN;
    const { rows } = plot.panel;
    plot.output.textContent = !Number.isFinite(first)
      ? ""
      : rows.length
        ? (rows[first] ?? "")
        : `${Number(first.toPrecision(3))}`.replace("-", "\u2212").replace(".", film.words.point);
    if (plot.strokes.length) plot.output.style.color = plot.strokes[0].colour;
  }

  function grab(plot, event) {
    const f = plot.frame;
    const box = plot.box.getBoundingClientRect();
    seek(f.t0 + ((event.clientX - box.left - f.left) / (f.right - f.left)) * (f.t1 - f.t0));
  }

  // --- the clock
  const slider = $("duet-time");
  const button = $("duet-play");
  const speed = $("duet-speed");
  const clock = $("duet-clock");
  slider.max = String(last);
  let now = 0;
  let playing = false;
  let before = 0;

  function show() {
    const frame = Math.min(Math.floor(now + 1e-6), last);
    move(frame);
    for (const plot of plots) point(plot, timeOf(now));
    slider.value = String(frame);
    const seconds = (at) => timeOf(at).toFixed(2).replace(".", film.words.point);
    slider.setAttribute("aria-valuetext", `${seconds(frame)} s`);
    clock.textContent = film.words.of.replace("{time}", seconds(frame)).replace("{end}", seconds(last));
  }

  function go(to) {
    now = Number.isFinite(to) ? Math.min(Math.max(to, 0), last) : 0;
    show();
  }

  function seek(time) {
    play(false);
    go(Math.round((time - film.begin) * film.rate));
  }

  function play(on) {
    playing = on;
    button.textContent = on ? "\u275A\u275A" : "\u25B6";
    button.setAttribute("aria-label", on ? film.words.pause : film.words.play);
    if (on && now >= last) go(0);
    before = performance.now();
  }

  function tick() {
    const time = performance.now();
    if (playing) {
      const to = now + ((time - before) / 1000) * film.rate * Number(speed.value);
      go(to);
      if (to >= last) play(false);
    }
    before = time;
    requestAnimationFrame(tick);
  }

  slider.addEventListener("input", () => {
    play(false);
    go(Number(slider.value));
  });
  button.addEventListener("click", () => play(!playing));
  document.addEventListener("keydown", (event) => {
    if (event.target.closest?.("input, select, button")) return;
    if (event.code === "Space") {
      event.preventDefault();
      play(!playing);
    }
    if (event.key === "," || event.key === ".") {
      play(false);
      go(Math.round(now) + (event.key === "." ? 1 : -1));
    }
  });
  const redraw = () => {
    for (const plot of plots) draw(plot);
    show();
  };
  new ResizeObserver(redraw).observe($("duet-plots"));
  redraw();
  if (film.mark) seek(film.mark.time);
  tick();

  // --- the scene, as soon as viser has put it up
  const there = () => {
    const page = window.__viserMutable;
    const nodes = page?.nodeRefFromName;
    if (nodes && film.bodies.every((name) => nodes[name]) && page.messageQueue.length === 0) {
      viser = page;
      show();
      duet.ready = true;
      dispatchEvent(new Event("duet-built"));
    } else requestAnimationFrame(there);
  };
  const state = {
    seek,
    play,
    ready: false,
    get time() {
      return timeOf(now);
    },
    get playing() {
      return playing;
    },
  };
  Object.defineProperties(duet, Object.getOwnPropertyDescriptors(state));
  there();
})();
