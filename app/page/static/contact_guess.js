// The student's guess of d on the axis of the card: a slider over the axis, by mouse, finger or keys; the mark itself is in the chart.
(() => {
  const THUMB = 26;

  // Adds the slider to the card; returns a function that shows it on a chart. `moved` is called while it is dragged.
  duet.contactGuess = (card, moved) => {
    const slider = document.createElement("input");
    Object.assign(slider, { type: "range", className: "guess", hidden: true, step: 1 });
    // A name of its own from the beginning, so that it is not named after a row of the panels.
    slider.setAttribute("aria-label", "d");
    card.append(slider);
    let guess = null;
    let chart = null;
    let unit = "mm";
    const say = () => slider.setAttribute("aria-valuetext", `${slider.value} ${unit}`);
    const place = () => {
      if (slider.hidden || chart === null) return;
      const { left, right, axis } = chart.dataset;
      const { width } = chart.viewBox.baseVal;
      const [outer, inner] = [card.getBoundingClientRect(), chart.getBoundingClientRect()];
      const scale = inner.width / width;
      const start = (left - ((right - left) * -slider.min) / slider.max) * scale - THUMB / 2;
      slider.style.left = `${inner.left - outer.left - card.clientLeft + start}px`;
      slider.style.top = `${inner.top - outer.top - card.clientTop + axis * scale - THUMB * 0.75}px`;
      slider.style.width = `${(((right - left) * (slider.max - slider.min)) / slider.max) * scale + THUMB}px`;
    };
    new ResizeObserver(place).observe(card);
    slider.addEventListener("input", () => {
      guess.mm = Number(slider.value);
      say();
      moved();
    });
    slider.addEventListener("change", () => {
      // The box itself may be in a folded panel, which is not on the page.
      const updates = { value: `${guess.at} ${slider.value}` };
      window.__viserMutable.sendMessage({ type: "GuiUpdateMessage", uuid: guess.box, updates });
    });
    return (words, drawn) => {
      // What the server says of a guess that is being moved is late.
      if (!slider.hidden && document.activeElement === slider && words.guess?.at === guess.at)
        words.guess.mm = Number(slider.value);
      guess = words.guess;
      chart = drawn;
      slider.hidden = !guess?.box;
      if (slider.hidden) return;
      slider.min = -Math.round(words.span / 10);
      slider.max = words.span;
      slider.value = guess.mm ?? duet.firstGuess(words);
      unit = words.mm ?? "mm";
      slider.setAttribute("aria-label", `${guess.name} [${unit}]`);
      say();
      place();
    };
  };
  // Where the mark waits before there is a guess [mm].
  duet.firstGuess = (words) => Math.round(0.8 * words.span);
})();
