// The chart of the card: the obstacle, the gap as an axis in mm, λ on it, and the arm's closest point as a bead below its λ. The axis
// is the true distance d everywhere. A law that sees another one has its λ(d_law) where the two are as far apart as they are now.
(() => {
  const WIDE = { width: 330, height: 92, left: 58, right: 316, top: 10, axis: 66, bead: 8 };
  const NARROW = { width: 214, height: 84, left: 42, right: 204, top: 8, axis: 58, bead: 7 };
  const FACE = 'system-ui,-apple-system,"Segoe UI",Roboto,"Noto Sans","Liberation Sans",sans-serif';
  const SMALL = `600 12px ${FACE}`;
  const LARGE = `700 15px ${FACE}`;
  // A λ of a name of several letters.
  const LONG = `700 12px ${FACE}`;
  const ROW = 14;
  const { set, say } = duet;

  // Boxes of a text of the row below the axis: centred at x, else moved to either side, as far as it still reaches x.
  const along = (x, width, top, order) =>
    order.map((shift) => ({
      left: x + shift * (width / 2 + 4) - width / 2,
      right: x + shift * (width / 2 + 4) + width / 2,
      top,
      bottom: top + ROW,
    }));

  // Builds the chart in an <svg>; returns a function that draws a state of the moment.
  duet.contactChart = (root, words, narrow) => {
    const g = narrow ? NARROW : WIDE;
    root.replaceChildren();
    set(root, { viewBox: `0 0 ${g.width} ${g.height}` });
    Object.assign(root.dataset, { left: g.left, right: g.right, axis: g.axis });
    const svg = (name, attributes) => duet.svg(root, name, attributes);
    const x = (mm) => g.left + ((g.right - g.left) * Math.min(Math.max(mm, -0.12 * words.span), words.span)) / words.span;
    const y = (share) => g.axis - (g.axis - g.top) * Math.min(Math.max(share, 0), 1);

    const known = words.curve.length > 0;
    const area = known ? svg("polygon", { class: "lam area", "data-symbol": "lam" }) : null;
    const outline = known ? svg("polyline", { class: "lam curve", "data-symbol": "lam" }) : null;
    let curve = [];
    let ahead = null;
    // Draws λ with the true distance ahead of the law's by some mm; at either end the curve goes on as it ends.
    const drawCurve = (mm) => {
      if (!known || mm === ahead) return;
      ahead = mm;
      curve = [];
      for (let i = 0; i < words.curve.length; i += 2) {
        const at = Math.min(Math.max(words.curve[i] + mm, 0), words.span);
        curve.push([x(at), y(words.curve[i + 1] / 1000)]);
      }
      curve = [[g.left, curve[0][1]], ...curve, [g.right, curve.at(-1)[1]]];
      const line = curve.map((point) => point.map((n) => n.toFixed(1)).join()).join(" ");
      set(area, { points: `${g.left},${g.axis} ${line} ${g.right},${g.axis}` });
      set(outline, { points: line });
    };
    const dm = x(words.dm);
    svg("line", { class: "axis", x1: g.left, x2: g.right, y1: g.axis, y2: g.axis });
    svg("line", { class: "dm limit", "data-symbol": "dm", x1: dm, x2: dm, y1: g.top - 6, y2: g.axis + 6 });
    const ticks = [];
    for (let mm = 100; mm <= words.span; mm += 100) {
      svg("line", { class: "axis", x1: x(mm), x2: x(mm), y1: g.axis, y2: g.axis + 4 });
      ticks.push({ mm, text: svg("text", { class: "tick" }) });
    }
    // An obstacle that gives way itself is a bead with a λ of its own.
    const twin = svg("g", { class: "lam", "data-symbol": "lam", visibility: words.two ? "visible" : "hidden" });
    const twinStem = duet.svg(twin, "line", { class: "stem", x1: g.left, x2: g.left, y1: g.axis });
    const twinTip = duet.svg(twin, "circle", { class: "tip", cx: g.left, r: 5 });
    if (words.two) svg("circle", { class: `body ${words.obstacle[0]}`, cx: g.left, cy: g.axis, r: g.bead });
    else
      svg("rect", {
        class: `body ${words.obstacle[0]}`,
        "data-symbol": "w",
        ...{ x: 8, y: g.axis - 28, width: g.left - 8, height: 37, rx: words.obstacle[0] === "orange" ? 9 : 5 },
      });
    const ghost = svg("circle", { class: "ghost", cy: g.axis, r: g.bead - 2 });
    const rest = svg("path", { class: "rest", "data-symbol": "rest" });
    const stem = svg("line", { class: "lam stem", "data-symbol": "lam", y1: g.axis });
    const tip = svg("circle", { class: "lam tip", "data-symbol": "lam", r: 5 });
    const bead = svg("circle", { class: `body ${words.arm[0]}`, "data-symbol": "d", cy: g.axis, r: g.bead });
    const off = svg("path", { class: "off" });
    const guess = words.guess;
    const mark = svg("path", { class: `guess${guess?.mm === null ? " waits" : ""}` });
    const long = words.share.length > 2;
    const labels = {
      dm: svg("text", { class: "dm", "data-symbol": "dm" }),
      rest: svg("text", { class: "rest", "data-symbol": "rest" }),
      guess: svg("text", { class: "guess" }),
      ghost: svg("text", { class: "tick" }),
      body: svg("text", { class: "tick" }),
      lam: svg("text", { class: `lam ${long ? "long" : "large"}`, "data-symbol": "lam" }),
    };
    duet.svg(labels.dm, "tspan").textContent = words.symbol ?? "d";
    duet.svg(labels.dm, "tspan", { dy: 3, "font-size": 11.5 }).textContent = "m";
    duet.svg(labels.dm, "tspan", { dy: -3, dx: 3 }).textContent = words.dm;
    // "gives way" is smaller, so that it finds room beside λ more often.
    const gives = duet.svg(labels.lam, "tspan", { class: "gives" });
    const shareText = duet.svg(labels.lam, "tspan");
    labels.ghost.textContent = words.ghost;
    labels.body.textContent = words.obstacle[1];

    const put = (label, box) => {
      label.style.display = box ? "" : "none";
      if (box) set(label, { x: box.left.toFixed(1), y: (box.bottom - 3).toFixed(1) });
    };
    const crossed = (box) =>
      curve.some(([a, b], i) => {
        const [c, d] = curve[i + 1] ?? [a, b];
        return a < box.right && c > box.left && Math.min(b, d) < box.bottom && Math.max(b, d) > box.top;
      });

    return (s) => {
      drawCurve(s.d === null || s.law === null ? 0 : Math.round(s.d - s.law));
      const at = x(s.d);
      const height = y(s.lam);
      const far = s.d > words.span;
      set(bead, { cx: at.toFixed(1) });
      set(stem, { x1: at.toFixed(1), x2: at.toFixed(1), y2: height.toFixed(1) });
      set(tip, { cx: at.toFixed(1), cy: height.toFixed(1) });
      set(twinStem, { y2: height.toFixed(1) });
      set(twinTip, { cy: height.toFixed(1) });
      set(off, { d: far ? `M${g.right - 2},${g.axis - 4}l4,4l-4,4` : "" });
      set(ghost, { cx: x(s.ghost ?? 0).toFixed(1), visibility: s.ghost === null ? "hidden" : "visible" });
      const guessed = guess ? x(guess.mm ?? duet.firstGuess(words)) : 0;
      set(mark, { d: guess ? `M${guessed.toFixed(1)},${g.axis - 1}l-7,-12h14z` : "" });
      set(rest, { d: s.rest === null ? "" : `M${x(s.rest).toFixed(1)},${g.axis + 1}l-5,8h10z` });

      // The row below the axis: d_m and d* first, then what is at the left, the ghost, and the ticks that are left free.
      const top = g.axis + 9;
      const close = s.rest !== null && Math.abs(x(s.rest) - dm) < 80;
      const side = close ? Math.sign(x(s.rest) - dm) || 1 : 0;
      const measure = (text) => duet.textWidth(text, SMALL);
      const restText = s.rest === null ? "" : `${words.symbol ?? "d"}* ${Math.round(s.rest)}`;
      say(restText, labels.rest);
      const dmWidth = measure(`dm ${words.dm}`) + 1;
      const dmBoxes = along(dm, dmWidth, top, close ? [-0.8 * side, -side, 0] : [0, 0.8, -0.8]);
      const restWidth = measure(restText);
      const restBoxes = s.rest === null ? [] : along(x(s.rest), restWidth, top, [0, side, -side, 1.3 * side, 1.6 * side]);
      say(guess ? `${guess.name}${guess.mm === null ? "" : ` ${guess.mm}`}` : "", labels.guess);
      const guessWidth = measure(labels.guess.textContent);
      const bodyWidth = measure(words.obstacle[1]);
      const bounds = { left: 4, right: g.width - 4, top: 0, bottom: g.height };
      const rows = [
        dmBoxes,
        restBoxes,
        // Where the row is full, the guess stands above its mark.
        guess ? [top, g.axis - 16 - ROW].flatMap((height) => along(guessed, guessWidth, height, [0, 0.8, -0.8, 1.1, -1.1])) : [],
        [{ left: 8, right: 8 + bodyWidth, top: top + 1, bottom: top + 1 + ROW }],
        s.ghost === null ? [] : along(x(s.ghost), measure(words.ghost), top, [0, 1, -1]),
        ...ticks.map(({ mm }, i) => {
          const text = i === ticks.length - 1 ? `${mm} ${words.mm ?? "mm"}` : `${mm}`;
          say(text, ticks[i].text);
          return along(x(mm), measure(text), top, [0]);
        }),
      ];
      const boxes = duet.placeLabels(rows, bounds, []);
      put(labels.dm, boxes[0]);
      put(labels.rest, boxes[1]);
      put(labels.guess, boxes[2]);
      put(labels.body, boxes[3]);
      put(labels.ghost, boxes[4]);
      for (const [i, tick] of ticks.entries()) put(tick.text, boxes[5 + i]);

      // λ beside its point: off the curve, off the line of d_m, above the axis; the number alone where its name finds no room.
      const body = { left: 0, right: g.left, top: g.axis - 28, bottom: g.axis + 9 };
      const limit = { left: dm - 2, right: dm + 2, top: g.top - 6, bottom: g.axis };
      const free = (list, taken) => duet.placeLabels([list], { ...bounds, top: narrow ? 1 : -4 }, taken)[0];
      const beside = ([said, text]) => {
        const width = (said ? duet.textWidth(said, SMALL) : 0) + duet.textWidth(text, long ? LONG : LARGE);
        return [0, -10, 10, -20, 20, -30, 30, -40, 40].flatMap((rise) => {
          const middle = Math.min(height + rise, g.axis - g.bead - 9);
          return [at + 9, at - 9 - width].map((left) => ({ left, right: left + width, top: middle - 8, bottom: middle + 8 }));
        });
      };
      const number = s.lam.toFixed(2).replace(".", words.point);
      const clear = (text) =>
        free(
          beside(text).filter((box) => !crossed(box)),
          boxes[2] ? [body, limit, boxes[2]] : [body, limit],
        );
      const named = ["", `${words.share} ${number}`];
      const alone = ["", number];
      const texts = long ? [named, alone] : [[`${words.gives} `, named[1]], named, alone];
      const text = texts.find(clear) ?? alone;
      say(text[0], gives);
      say(text[1], shareText);
      put(labels.lam, clear(text) ?? free(beside(text), []));
    };
  };

  // Of an arm that stands alone: its error now and after each of the next steps, every time (1 − K dt) of the one before. Returns a
  // function that draws the bars, if there is an error to be seen.
  duet.errorChart = (root, words, narrow) => {
    const g = narrow ? NARROW : WIDE;
    root.replaceChildren();
    set(root, { viewBox: `0 0 ${g.width} ${g.height}` });
    const middle = words.step < 0 ? (g.axis + g.top) / 2 : g.axis - 4;
    const room = words.step < 0 ? (g.axis - g.top) / 2 : g.axis - 4 - g.top;
    // Of an error that grows only as many steps as leave the first one to be seen.
    const growth = Math.abs(words.step);
    const count = growth > 1 ? Math.min(Math.max(Math.floor(1 + Math.log(30) / Math.log(growth)), 3), 12) : 12;
    const largest = Math.max(1, growth ** (count - 1));
    const place = (i) => 16 + ((g.width - 32) * i) / (count - 1);
    duet.svg(root, "line", { class: "axis", x1: 8, x2: g.width - 8, y1: middle, y2: middle });
    const bars = Array.from({ length: count }, (_, i) => [
      duet.svg(root, "line", { class: "e stem", "data-symbol": "e", x1: place(i), x2: place(i), y1: middle }),
      duet.svg(root, "circle", { class: "e tip", "data-symbol": "e", cx: place(i), r: i === 0 ? 6 : 4 }),
    ]);
    duet.svg(root, "text", { class: "tick", x: g.width - 8, y: g.axis + 20, "text-anchor": "end" }).textContent = words.axis;
    // Of no error there are no bars.
    return (there) => {
      bars.forEach(([stem, tip], i) => {
        const end = there ? middle - (room * words.step ** i) / largest : middle;
        set(stem, { y2: end });
        set(tip, { cy: end });
      });
    };
  };
})();
