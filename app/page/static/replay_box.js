// Presses the key that pauses the replay when the box beside its scrubber gets the focus, and at everything that is typed there.
(() => {
  const pause = ({ target: box }) => {
    const mark = document.querySelector("[data-duet-moment]");
    if (!mark || !(box instanceof HTMLInputElement)) return;
    const track = document.getElementById(mark.dataset.duetMoment);
    if (track && !track.contains(box) && track.parentElement.contains(box)) duet.pressKey(duet.replayKey);
  };
  for (const kind of ["focusin", "beforeinput"]) addEventListener(kind, pause, true);
})();
