// A press and a drag over a plot over time, of a run that stands or is replayed, choose the moment that the whole page shows.
(() => {
  const PERIOD_MS = 40;
  let plot = null;
  let wanted = null;
  let waits = false;

  const send = () => {
    const box = document.querySelector("[data-duet-seek]")?.dataset.duetSeek;
    if (wanted === null || !box) return;
    window.__viserMutable?.sendMessage({ type: "GuiUpdateMessage", uuid: box, updates: { value: wanted } });
    wanted = null;
    waits = true;
    setTimeout(() => {
      waits = false;
      send();
    }, PERIOD_MS);
  };
  const choose = (event) => {
    const span = document.querySelector("[data-duet-span]")?.dataset.duetSpan;
    if (!plot || !span) return;
    const [begin, end] = span.split(" ").map(Number);
    const { left, width } = plot.getBoundingClientRect();
    const share = Math.min(Math.max((event.clientX - left) / width, 0), 1);
    wanted = (begin + share * (end - begin)).toFixed(3);
    if (!waits) send();
  };
  addEventListener(
    "pointerdown",
    (event) => {
      plot = event.button === 0 && event.target instanceof Element ? event.target.closest(".u-over") : null;
      choose(event);
    },
    true,
  );
  addEventListener("pointermove", choose, true);
  for (const kind of ["pointerup", "pointercancel"])
    addEventListener(
      kind,
      () => {
        plot = null;
      },
      true,
    );
})();
