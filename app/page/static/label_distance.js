// Says every d that comes for the label of the line in the scene: the card's own numbers come ten times a second only.
(() => {
  const LABEL = "/closest/distance";
  let said = () => {};
  // Calls back with d [mm], negative in overlap, as soon as it has come.
  duet.onLabelDistance = (callback) => {
    said = callback;
  };
  // "d = 180 mm", "h = −12 mrad", or a number and the words for an overlap.
  const read = (text) => (/^\d|−\d/.test(text) ? -1 : 1) * Number(text.match(/\d+/));

  const Native = window.Worker;
  window.Worker = class extends Native {
    constructor(...given) {
      super(...given);
      this.addEventListener("message", ({ data }) => {
        if (data?.type !== "message_batch") return;
        const text = data.messages.findLast(({ name, updates }) => name === LABEL && updates?.text)?.updates.text;
        if (text) said(read(text));
      });
    }
  };
})();
