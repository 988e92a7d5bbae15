// The editor of a law: one text area, which stands wherever the server leaves a place for it (`.duet-law-place`). What is typed is never
// overwritten: the server says what the file holds (`.duet-law-state`), and only an untouched text follows it.
(() => {
  const LOOK_MS = 200;
  const INDENT = 4;

  const editor = document.createElement("div");
  editor.className = "duet-law";
  editor.innerHTML = `<p class="lamps" aria-hidden="true"></p><div class="code"><i class="mark" hidden></i><pre aria-hidden="true"></pre><textarea wrap="off" rows="12"
    spellcheck="false" autocapitalize="off" autocomplete="off"></textarea><p class="fault" hidden></p></div><p class="said" role="status"></p>
    <p class="both" hidden><button type="button"></button><button type="button"></button></p>
    <p class="do"><button type="button"></button><span class="duet-tip"></span></p>`;
  const area = editor.querySelector("textarea");
  const lines = editor.querySelector("pre");
  const lamps = editor.querySelector(".lamps");
  const [mark, fault, said, both] = [".mark", ".fault", ".said", ".both"].map((name) => editor.querySelector(name));
  const [keep, take, run] = editor.querySelectorAll("button");
  const bytes = new TextEncoder();

  let read = "";
  let state = null;
  // The version of the file that the text was made from, with its text; what was sent last, and its number.
  let base = null;
  let sent = { number: "", text: "" };
  let number = Date.now();
  let leaves = false;
  let pointed = "";

  const touched = () => base !== null && area.value !== base.text;
  const kept = () => `duet-law ${state.file}`;
  const count = () => area.value.split("\n").length;

  const place = () => {
    editor.style.setProperty("--top", `${-area.scrollTop}px`);
  };
  const numberLines = () => {
    const now = count();
    if (Number(lines.dataset.count) === now) return;
    lines.dataset.count = now;
    lines.textContent = Array.from({ length: now }, (_, i) => i + 1).join("\n");
    mark.hidden = true;
  };
  const remember = () => {
    try {
      if (touched()) sessionStorage.setItem(kept(), JSON.stringify({ sha: base.sha, was: base.text, text: area.value }));
      else sessionStorage.removeItem(kept());
    } catch {
      // A browser that keeps nothing.
    }
  };
  const remembered = () => {
    try {
      return JSON.parse(sessionStorage.getItem(kept()));
    } catch {
      return null;
    }
  };
  const say = (text, bad = false) => {
    said.textContent = text;
    said.classList.toggle("bad", bad);
  };
  const point = () => {
    const there = Boolean(state.line) && state.line <= count() && !touched();
    mark.hidden = fault.hidden = !there;
    if (!there) return;
    editor.style.setProperty("--line", state.line);
    fault.textContent = state.problem;
    place();
    // Once for a mistake: the visitor may scroll away.
    if (pointed === state.sha) return;
    pointed = state.sha;
    const height = Number.parseFloat(getComputedStyle(area).lineHeight);
    const top = (state.line - 1) * height;
    if (top < area.scrollTop || top + 3 * height > area.scrollTop + area.clientHeight)
      area.scrollTop = Math.max(top - 3 * height, 0);
  };
  const typed = () => {
    numberLines();
    fault.hidden = true;
    if (touched()) say(state.words.unsaved);
    remember();
  };
  const insert = (text) => {
    // The one way that undo knows of.
    if (!document.execCommand("insertText", false, text)) area.setRangeText(text, area.selectionStart, area.selectionEnd, "end");
  };

  const send = () => {
    if (!state?.box || base === null) return;
    if (bytes.encode(area.value).length > state.most) return say(state.words.large, true);
    sent = { number: String(++number), text: area.value };
    both.hidden = true;
    say(state.words.saving);
    const updates = { value: `${sent.number} ${base.sha}\n${sent.text}` };
    window.__viserMutable.sendMessage({ type: "GuiUpdateMessage", uuid: state.box, updates });
  };

  const follow = () => {
    const words = state.words;
    [keep.textContent, take.textContent, run.textContent] = [words.keep, words.take, words.run];
    editor.querySelector(".do span").textContent = words.how;
    area.setAttribute("aria-label", `${state.title}. ${words.how}`);
    const answer = state.number === sent.number ? state.said : "";
    if (base === null) {
      area.rows = state.rows;
      const old = remembered();
      base = old ? { sha: old.sha, text: old.was } : { sha: state.sha, text: state.text };
      area.value = old ? old.text : state.text;
      say(old ? words.unsaved : "");
    } else if (answer === "saved") {
      base = { sha: state.sha, text: sent.text };
      say(touched() ? words.unsaved : words.saved);
    } else if (!touched() && state.sha !== base.sha) {
      base = { sha: state.sha, text: state.text };
      area.value = state.text;
    }
    if (answer === "saved" && state.problem && !touched()) say(words.fails, true);
    if (answer === "conflict") say(words.conflict, true);
    both.hidden = answer !== "conflict";
    if (state.refused) say(state.refused, true);
    lamps.replaceChildren(
      ...state.lamps.map(([kind, title]) => Object.assign(document.createElement("i"), { className: kind, title })),
    );
    numberLines();
    point();
    remember();
  };

  const look = () => {
    const at = [...document.getElementsByClassName("duet-law-place")].find((one) => one.offsetParent !== null);
    if (!at) return;
    if (editor.parentElement !== at) {
      const [top, focused] = [area.scrollTop, document.activeElement === area];
      at.append(editor);
      area.scrollTop = top;
      if (focused) area.focus({ preventScroll: true });
    }
    const now = [...document.getElementsByClassName("duet-law-state")].find((one) => one.dataset.text)?.dataset.text;
    if (!now || now === read) return;
    read = now;
    const box = state?.box;
    state = JSON.parse(now);
    follow();
    // On another connection what was on its way is lost.
    if (box && box !== state.box && touched() && !state.refused) say(state.words.unsaved);
  };
  setInterval(look, LOOK_MS);

  // ---- keys
  const lineStart = (at) => area.value.lastIndexOf("\n", at - 1) + 1;
  const shiftLines = (back) => {
    const begin = lineStart(area.selectionStart);
    const last = area.selectionEnd > area.selectionStart && area.value[area.selectionEnd - 1] === "\n" ? 1 : 0;
    const next = area.value.indexOf("\n", area.selectionEnd - last);
    const end = next < 0 ? area.value.length : next;
    const old = area.value.slice(begin, end);
    const shifted = back ? old.replace(/^( {1,4}|\t)/gm, "") : old.replace(/^(?=[^\n])/gm, " ".repeat(INDENT));
    if (shifted === old) return;
    const [caret, single] = [area.selectionStart, area.selectionStart === area.selectionEnd];
    area.setSelectionRange(begin, end);
    insert(shifted);
    if (single)
      area.setSelectionRange(
        Math.max(caret + shifted.length - old.length, begin),
        Math.max(caret + shifted.length - old.length, begin),
      );
    else area.setSelectionRange(begin, begin + shifted.length);
  };
  const indent = () => {
    const column = area.selectionStart - lineStart(area.selectionStart);
    if (area.value.slice(area.selectionStart, area.selectionEnd).includes("\n")) shiftLines(false);
    else insert(" ".repeat(INDENT - (column % INDENT)));
  };
  const newLine = () => {
    const before = area.value.slice(lineStart(area.selectionStart), area.selectionStart);
    insert(`\n${/^[ \t]*/.exec(before)[0]}${/:\s*(#.*)?$/.test(before) ? " ".repeat(INDENT) : ""}`);
  };
  const press = (event) => {
    const plain = !(event.ctrlKey || event.metaKey || event.altKey || event.isComposing);
    event.stopPropagation();
    if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) send();
    else if (event.key === "Tab" && plain && !leaves) event.shiftKey ? shiftLines(true) : indent();
    else if (event.key === "Enter" && plain && !event.shiftKey) newLine();
    else {
      leaves = event.key === "Escape" || (leaves && event.key === "Shift");
      return;
    }
    event.preventDefault();
  };
  area.addEventListener("keydown", press);
  area.addEventListener("focus", () => {
    leaves = false;
  });
  area.addEventListener("input", typed);
  area.addEventListener("scroll", place);
  run.addEventListener("click", send);
  keep.addEventListener("click", () => {
    base = { sha: state.sha, text: state.text };
    send();
  });
  take.addEventListener("click", () => {
    base = { sha: state.sha, text: state.text };
    area.focus();
    area.select();
    insert(state.text);
    send();
  });
})();
