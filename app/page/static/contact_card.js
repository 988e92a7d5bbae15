// The card of the line of contact, over the stage's top left corner: what the server sends in `.duet-contact-words`, `-note` and, ten
// times a second, in `-now`, as a drawing.

// Functions that add to the card before it is shown; each returns one that shows its addition as the card's words say.
duet.cardAdditions = [];

addEventListener("DOMContentLoaded", () => {
  const FOLDED = "duet-contact-folded";
  const EASE_MS = 70;
  // Nothing is eased where that would take the time of the picture, or where the reader has asked for less motion.
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  const phone = matchMedia("(max-width: 36em)");

  const card = document.createElement("section");
  card.id = "duet-contact";
  card.className = "duet";
  card.hidden = true;
  card.innerHTML = `<button type="button" aria-controls="duet-contact-picture"></button><button type="button" class="tone" aria-pressed="false">♪</button>
    <div id="duet-contact-picture" role="group"><header><span class="gap"><b></b> <span></span></span><b class="trend"></b></header>
    <svg class="chart" aria-hidden="true"></svg><svg class="balance" aria-hidden="true"></svg>
    <div class="terms"></div><div class="legend"></div><p class="note"></p></div>`;
  const find = (selector) => card.querySelector(selector);
  const { say } = duet;
  const button = find("button");
  const picture = find("#duet-contact-picture");
  const number = find(".gap b");
  const unit = find(".gap span");
  const trend = find(".trend");
  const cells = find(".terms");
  const legend = find(".legend");
  const note = find(".note");
  document.body.append(card);
  const toneButton = find(".tone");
  const sound = duet.lambdaTone(toneButton);

  let folded = false;
  try {
    folded = localStorage.getItem(FOLDED) === "1";
  } catch {
    // A browser that keeps nothing shows it unfolded.
  }
  let words = null;
  const fold = () => {
    card.classList.toggle("folded", folded);
    button.setAttribute("aria-expanded", String(!folded));
    const label = (folded ? words?.unfold : words?.fold) ?? "";
    button.title = label;
    button.setAttribute("aria-label", label);
  };
  button.addEventListener("click", () => {
    folded = !folded;
    try {
      localStorage.setItem(FOLDED, folded ? "1" : "0");
    } catch {
      // As above.
    }
    fold();
    if (shown !== null) draw();
  });

  const showGuess = duet.contactGuess(card, () => {
    if (shown !== null) draw();
  });
  const additions = duet.cardAdditions.map((add) => add(card));
  let drawChart = () => {};
  let drawBalance = () => {};
  let wanted = null;
  let shown = null;
  const seen = { words: "", note: "", now: "", phone: null };

  const build = () => {
    const narrow = phone.matches;
    const alone = words.step !== undefined;
    card.hidden = false;
    card.classList.toggle("alone", alone);
    card.classList.toggle("asks", words.asks === true);
    card.classList.toggle("replayed", words.past !== undefined);
    card.setAttribute("aria-label", words.name);
    toneButton.title = words.tone;
    toneButton.setAttribute("aria-label", words.tone);
    fold();
    for (const show of additions) show(words);
    if (alone) {
      drawChart = duet.errorChart(find(".chart"), words, narrow);
      drawBalance = () => {};
      cells.textContent = "";
      legend.textContent = "";
      showGuess(words, null);
      return;
    }
    drawChart = duet.contactChart(find(".chart"), words, narrow);
    showGuess(words, find(".chart"));
    drawBalance = duet.contactBalance(find(".balance"), words, narrow ? 156 : 310);
    cells.innerHTML = words.terms
      .map(
        ([kind, symbol, word]) =>
          `<span class="term" data-symbol="${kind}"><i class="${kind}"></i><b>${symbol}</b> <b class="${kind} value"></b><small>${word}</small></span>`,
      )
      .join("");
    legend.innerHTML = words.legend
      .map(([kind, text]) => `<span data-symbol="${kind}"><i class="${kind}"></i>${text}</span>`)
      .join("");
  };

  const fixed = (mm) =>
    (mm / 1000)
      .toFixed(2)
      .replace(/^-(?=0\.00$)/, "")
      .replace(".", words.point)
      .replace("-", "−");

  // The sum as it stands in the formula: ḋ = λ v − (1 − λ) u − w.
  const inFormula = (kind, value) => (kind === "u" || kind === "w" ? -value : value);

  const read = (text) => {
    const [d, law, rest, ghost, lam, u, w, allowed, way, ...terms] = text
      .split(",")
      .map((one) => (one === "" ? null : Number(one)));
    return { d, law, rest, ghost, lam: lam / 1000, u, w, allowed, way, terms };
  };

  const showNote = (allowed) => {
    const asked = words.guess?.box && words.guess.mm === null;
    const [kind, text] = asked ? ["", words.guess.hint] : JSON.parse(seen.note || '["",""]');
    note.className = `note ${kind}`;
    if (note.dataset.text !== text) note.innerHTML = note.dataset.text = text;
    const place = note.querySelector("[data-allowed]");
    if (place) say(fixed(Math.abs(allowed)), place);
  };

  // As the label in the scene says it, which is newer than the numbers of the card while it changes.
  let labelled = null;
  let isNew = false;
  const showDistance = (mm) => {
    number.className = mm < words.dm ? "d below" : "d";
    say(String(Math.abs(mm)), number);
    say(mm < 0 ? words.overlap : words.apart, unit);
  };
  duet.onLabelDistance((mm) => {
    labelled = mm;
    isNew = true;
    // viser takes the text at the next picture, and draws it with the one after.
    const show = () => wanted !== null && words.step === undefined && showDistance(labelled);
    requestAnimationFrame(() => requestAnimationFrame(show));
  });

  const showNumbers = () => {
    const s = wanted;
    number.parentElement.dataset.symbol = words.step === undefined ? "d" : "e";
    sound(words.step !== undefined || words.asks ? null : s.lam);
    showNote(words.step === undefined ? s.allowed : null);
    if (words.step !== undefined) {
      const mm = Number(seen.now) / 1000;
      number.className = "e";
      say(mm.toFixed(mm < 10 ? 1 : 0).replace(".", words.point), number);
      drawChart(Number(mm.toFixed(1)) > 0);
      say(words.off, unit);
      trend.className = "trend";
      say(words.title, trend);
      duet.symbols = { e: `${mm.toFixed(1).replace(".", words.point)} mm` };
      duet.bodies = {};
      picture.setAttribute("aria-label", `${number.textContent} ${words.off}; ${note.textContent}`);
      return;
    }
    showDistance(isNew ? labelled : s.d);
    isNew = false;
    if (words.asks) {
      trend.className = "trend";
      say("", trend);
      duet.symbols = null;
      duet.bodies = words.bodies;
      picture.setAttribute("aria-label", `${number.textContent} ${unit.textContent}. ${note.textContent}`);
      return;
    }
    trend.className = `trend ${["closes", "holds", "opens"][s.way + 1]}`;
    say(words.past === undefined ? words.trends[s.way + 1] : `${words.past}: ${words.trends[s.way + 1]}`, trend);
    cells.querySelectorAll(".value").forEach((value, i) => {
      say(fixed(inFormula(words.terms[i][0], s.terms[i])), value);
      if (words.terms[i][0] === "lost") value.parentElement.hidden = s.terms[i] === 0;
    });
    const lam = fixed(1000 * s.lam);
    const length = (mm) => `${mm} ${words.mm ?? "mm"}`.replace("-", "−");
    const both = { d: length(s.d), "d law": length(s.law), dm: length(words.dm), lam, v: fixed(words.v) };
    duet.letter = words.symbol ?? "d";
    // Of two arms that give way, each has a u of its own.
    duet.symbols = words.two ? both : { ...both, u: fixed(s.u), w: fixed(s.w) };
    duet.bodies = words.bodies;
    picture.setAttribute(
      "aria-label",
      `${number.textContent} ${unit.textContent}, ${trend.textContent}; ${words.share} ${lam}. ${note.textContent}`,
    );
  };

  const draw = () => {
    if (words.step !== undefined || folded) return;
    drawChart(shown);
    drawBalance(shown.terms, shown.allowed);
  };

  let last = 0;
  const ease = (time) => {
    if (words.step !== undefined) {
      // An arm alone has nothing to ease.
      last = 0;
      return;
    }
    const share = 1 - Math.exp(-Math.min(time - last, 100) / EASE_MS);
    last = time;
    const step = (from, to) => (from === null || to === null ? to : from + (to - from) * share);
    for (const key of ["d", "law", "rest", "ghost", "lam", "allowed"]) shown[key] = step(shown[key], wanted[key]);
    shown.terms = wanted.terms.map((term, i) => step(shown.terms[i] ?? null, term));
    const near = (a, b) => a === b || Math.abs(a - b) < 0.3;
    const there =
      ["d", "law", "rest", "ghost", "allowed"].every((key) => near(shown[key], wanted[key])) &&
      Math.abs(shown.lam - wanted.lam) < 0.002 &&
      wanted.terms.every((term, i) => near(shown.terms[i], term));
    if (there) shown = structuredClone(wanted);
    draw();
    if (!there) return requestAnimationFrame(ease);
    last = 0;
    card.dataset.drawn = seen.now;
  };

  const sent = (name) => document.querySelector(`.duet-contact-${name}`)?.dataset.text ?? "";

  const look = () => {
    const [newWords, newNote, now] = ["words", "note", "now"].map(sent);
    if (!newWords || !now) return;
    const rebuild = newWords !== seen.words || seen.phone !== phone.matches;
    if (!rebuild && now === seen.now && newNote === seen.note) return;
    const next = rebuild ? JSON.parse(newWords) : words;
    const parts = next.step === undefined ? next.terms.length + 9 : 1;
    // Words and numbers come one after the other.
    if (now.split(",").length !== parts) return;
    words = next;
    Object.assign(seen, { words: newWords, note: newNote, now, phone: phone.matches });
    if (rebuild) build();
    wanted = read(now);
    showNumbers();
    const jumps = rebuild || words.step !== undefined || duet.drawnBySoftware || still.matches || document.hidden || folded;
    if (jumps || shown === null) {
      shown = structuredClone(wanted);
      draw();
      card.dataset.drawn = now;
    } else if (last === 0) {
      last = performance.now();
      requestAnimationFrame(ease);
    }
  };
  setInterval(look, 50);
});
