// The projector: shows what `.duet-screen` holds over the whole page, and is black while there is a `.duet-blank`. What is there already
// is changed in its place, so that bars grow. On a teacher's page a button opens a projector's window, which is given the teacher's key.
addEventListener("DOMContentLoaded", () => {
  const screen = document.createElement("div");
  screen.id = "duet-screen";
  screen.hidden = true;
  const black = document.createElement("div");
  black.id = "duet-black";
  black.hidden = true;
  document.body.append(screen, black);

  const drop = (node) => {
    const next = node.nextSibling;
    node.remove();
    return next;
  };

  const turnInto = (old, fresh) => {
    if (old.isEqualNode(fresh)) return;
    if (old.nodeType !== Node.ELEMENT_NODE || fresh.nodeType !== Node.ELEMENT_NODE || old.tagName !== fresh.tagName) {
      old.replaceWith(fresh);
      return;
    }
    for (const { name } of [...old.attributes]) if (!fresh.hasAttribute(name)) old.removeAttribute(name);
    for (const { name, value } of fresh.attributes) if (old.getAttribute(name) !== value) old.setAttribute(name, value);
    let at = old.firstChild;
    for (const child of [...fresh.childNodes]) {
      let like = at;
      while (like && like.nodeName !== child.nodeName) like = like.nextSibling;
      if (!like) {
        old.insertBefore(child, at);
        continue;
      }
      while (at !== like) at = drop(at);
      at = like.nextSibling;
      turnInto(like, child);
    }
    while (at) at = drop(at);
  };

  // The question has 40 px on a screen of 1920 × 1080 or less, more on a larger one. Where a long text would not fit, all else is drawn
  // smaller first, and then the strip of the plot gives way, before letters can no longer be read from afar.
  const ALONE = 0.85;
  const SMALLEST = 0.45;
  const BESIDE_STRIP = 0.6;
  let strip = false;
  const fit = () => {
    const whole = Math.max(1, Math.min(innerWidth / 1920, innerHeight / 1080));
    const fits = () => {
      const main = screen.querySelector(".slide main");
      return !main || (main.scrollHeight <= main.clientHeight + 1 && main.scrollWidth <= main.clientWidth + 1);
    };
    const shrink = (least) => {
      for (let share = 1; share > least - 0.01; share -= 0.05) {
        screen.style.setProperty("--fit", (whole * share).toFixed(3));
        screen.style.setProperty("--fit-question", (whole * Math.min(1, share / ALONE)).toFixed(3));
        if (fits()) return true;
      }
      return false;
    };
    document.documentElement.classList.toggle("duet-strip", strip);
    if (strip && shrink(BESIDE_STRIP)) return;
    document.documentElement.classList.remove("duet-strip");
    shrink(SMALLEST);
  };

  // On the teacher's page a small projector shows what the large ones show, black and frozen too; it is no projector that counts.
  const openOf = (source) => {
    const query = new URLSearchParams(source.dataset.query);
    query.set("theme", document.documentElement.dataset.mantineColorScheme);
    return query;
  };
  const addThumbnail = () => {
    const place = document.querySelector(".duet-thumbnail:empty");
    if (!place?.clientWidth) return;
    const query = openOf(place);
    query.set("screen", "small");
    query.set("picture", "fast");
    const frame = document.createElement("iframe");
    frame.src = `${location.pathname}?${query}`;
    frame.inert = true;
    frame.style.scale = place.clientWidth / 1280;
    place.append(frame);
  };

  let [sent, slide] = ["", ""];
  const look = () => {
    const source = document.querySelector(".duet-screen");
    black.hidden = !document.querySelector(".duet-blank");
    if ((source?.innerHTML ?? "") === sent) return;
    sent = source?.innerHTML ?? "";
    screen.hidden = !source;
    const fresh = source?.firstElementChild?.cloneNode(true);
    const bare = Boolean(fresh) && !fresh.classList.contains("panels");
    document.documentElement.classList.toggle("duet-bare", bare);
    strip = bare && fresh.matches(".at-run, .at-outcome, .at-try");
    const title = fresh?.querySelector("header, .caption b")?.textContent ?? "";
    if (!fresh) screen.replaceChildren();
    // Another step is another picture: nothing of the one before grows into it.
    else if (screen.firstElementChild && title === slide) turnInto(screen.firstElementChild, fresh);
    else screen.replaceChildren(fresh);
    slide = title;
    fit();
  };
  setInterval(look, 150);
  setInterval(addThumbnail, 1000);
  addEventListener("resize", fit);

  document.addEventListener("click", (event) => {
    const button = event.target instanceof Element && event.target.closest(".duet-open-screen");
    if (!button) return;
    const query = openOf(button);
    if (duet.query.key) query.set("key", duet.query.key);
    // Without an opener: a window with one would share this tab's memory, and pass for this tab.
    open(`${location.pathname}?${query}`, "_blank", "popup,noopener,width=1280,height=720");
  });
});
