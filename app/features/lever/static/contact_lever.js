// The lever beside the card, where the visitor is λ: a vertical slider, by mouse, finger or keys; without a box it only shows how it stands.
(() => {
  // No more often than viser's own controls.
  const EVERY_MS = 50;
  // By how much an arrow key moves it [%].
  const NOTCH = 10;
  // How long what the server says of a lever that is being moved is late.
  const LATE_MS = 600;

  duet.cardAdditions.push((card) => {
    const lever = document.createElement("label");
    lever.className = "lever";
    lever.hidden = true;
    lever.innerHTML = `<span></span><b class="lam">λ</b><input type="range" min="0" max="100" step="1"><output class="lam"></output><span></span>`;
    const [top, bottom] = lever.querySelectorAll("span");
    const slider = lever.querySelector("input");
    const number = lever.querySelector("output");
    card.append(lever);
    let words = null;
    let late = 0;
    let timer = 0;
    const say = () => {
      number.textContent = (slider.value / 100).toFixed(2).replace(".", words.point);
      slider.setAttribute("aria-valuetext", number.textContent);
      slider.style.setProperty("--share", `${slider.value}%`);
    };
    const send = () => {
      timer = 0;
      const updates = { value: slider.value / 100 };
      if (words.lever?.box) window.__viserMutable.sendMessage({ type: "GuiUpdateMessage", uuid: words.lever.box, updates });
    };
    const follow = () => {
      late = 0;
      if (words.lever) slider.value = words.lever.value;
      say();
    };
    slider.addEventListener("input", () => {
      clearTimeout(late);
      late = setTimeout(follow, LATE_MS);
      say();
      if (timer === 0) timer = setTimeout(send, EVERY_MS);
    });
    // The keys of the page go on after a drag.
    slider.addEventListener("pointerup", () => slider.blur());
    slider.addEventListener("keydown", (event) => {
      const up = { ArrowUp: NOTCH, ArrowDown: -NOTCH }[event.key];
      if (!up) return;
      event.preventDefault();
      slider.value = Number(slider.value) + up;
      slider.dispatchEvent(new Event("input"));
    });
    return (now) => {
      words = now;
      lever.hidden = !now.lever;
      if (lever.hidden) return;
      [top.textContent, bottom.textContent] = now.lever.ends;
      slider.setAttribute("aria-label", now.lever.name);
      slider.disabled = !now.lever.box;
      if (late === 0) follow();
    };
  });
})();
