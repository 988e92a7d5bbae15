{
  // A link that was copied from the source of a page, or from a mail, has &amp; in place of &.
  const mended = location.search.replace(/&(?:amp(?:;|%3B))+/gi, "&");
  if (mended !== location.search) history.replaceState(history.state, "", location.pathname + mended + location.hash);
}
// What the server is to know of the browser, beside what the address says; connection.js sends it.
// `opened` is another one after a reload, and the same one after a lost connection.
duet.query = { window: `${innerWidth}x${innerHeight}`, opened: `${Math.round(performance.timeOrigin)}` };
// The websocket is opened by a worker, for which a browser need not send the languages of the page.
if (navigator.languages?.length) duet.query.languages = navigator.languages.slice(0, 9).join(",");
if (matchMedia("(prefers-reduced-motion: reduce)").matches) duet.query.motion = "less";
{
  // How many controls this browser's visitor wants; a link may say otherwise.
  let panel = null;
  try {
    panel = localStorage.getItem("duetPanel");
  } catch {
    // A browser that keeps nothing begins small.
  }
  duet.query.panel = panel ?? "small";
  // A proxy may have us in a folder of its own, which our address needs.
  const folder = location.pathname.replace(/\/[^/]*$/, "");
  if (folder) duet.query.folder = folder;
}
