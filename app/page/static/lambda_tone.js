// λ as a tone, for those who press its button: from 220 Hz for λ = 0 up to two octaves above for λ = 1.
// duet.lambdaTone(button) returns what is called with λ, or with null where there is none to be heard.
duet.lambdaTone = (button) => {
  const LOWEST_HZ = 220;
  const OCTAVES = 2;
  const LOUDNESS = 0.08;
  const EASE_S = 0.03;
  let audio = null;
  let tone = null;
  let volume = null;
  let lam = null;

  const set = () => {
    if (audio === null) return;
    const heard = lam !== null && button.ariaPressed === "true" && !document.hidden;
    volume.gain.setTargetAtTime(heard ? LOUDNESS : 0, audio.currentTime, EASE_S);
    if (heard) tone.frequency.setTargetAtTime(LOWEST_HZ * 2 ** (OCTAVES * lam), audio.currentTime, EASE_S);
    button.dataset.hertz = heard ? Math.round(LOWEST_HZ * 2 ** (OCTAVES * lam)) : "";
  };
  // A browser lets a page sound only after a press.
  button.addEventListener("click", () => {
    button.ariaPressed = String(button.ariaPressed !== "true");
    if (audio === null) {
      audio = new AudioContext();
      tone = new OscillatorNode(audio, { frequency: LOWEST_HZ });
      volume = new GainNode(audio, { gain: 0 });
      tone.connect(volume).connect(audio.destination);
      tone.start();
    }
    set();
  });
  document.addEventListener("visibilitychange", set);
  return (now) => {
    lam = now;
    set();
  };
};
