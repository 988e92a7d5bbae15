// What the server is to know of the browser, beside what the address says; connection.js sends it.
duet.query = { window: `${innerWidth}x${innerHeight}` };
{
  // A proxy may have us in a folder of its own, which our address needs.
  const folder = location.pathname.replace(/\/[^/]*$/, "");
  if (folder) duet.query.folder = folder;
}
