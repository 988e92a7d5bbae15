// Draws a curve on the axes of a lesson, `.duet-draw`, by mouse, finger or keys, and sends it once when a stroke has ended: as fractions
// of the height by column, null for a gap, through the hidden box behind the board.
(() => {
  const KEYS_REST_MS = 600;
  const STEP = 0.02;
  const FAR = 5;
  const typed = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set;
  const clamp = (value, most) => Math.min(Math.max(value, 0), most);
  const area = (board) => board.querySelector("svg svg");
  const columnsOf = (board) => area(board).viewBox.baseVal.width;

  const curveOf = (board) => {
    const curve = JSON.parse(board.dataset.curve);
    return curve.length ? curve : new Array(columnsOf(board)).fill(null);
  };
  const pathOf = (curve) => {
    let path = "";
    curve.forEach((height, column) => {
      if (height === null) return;
      const place = `${column + 0.5} ${(1 - height).toFixed(3)}`;
      path += column > 0 && curve[column - 1] !== null ? `L${place}` : `M${place}h.01`;
    });
    return path;
  };
  const show = (board, curve) => {
    board.dataset.curve = JSON.stringify(curve);
    board.querySelector(".pencil").setAttribute("d", pathOf(curve));
  };
  const send = (board) => {
    const box = board.closest(".duet-l-drawing")?.parentElement.nextElementSibling?.querySelector("input");
    if (!board.isConnected || !box) return;
    typed.call(box, `${board.dataset.at} ${board.dataset.curve}`);
    box.dispatchEvent(new Event("input", { bubbles: true }));
  };
  // Draws a straight line to a point, over what is there: at the middle of every column that it passes, and at its end.
  const fill = (board, from, to) => {
    const curve = curveOf(board);
    const last = Math.min(Math.floor(to.x), curve.length - 1);
    const way = to.x - from.x;
    const set = (column, height) => {
      curve[column] = Number(height.toFixed(3));
    };
    for (let column = 0; column < curve.length; column++) {
      const share = way === 0 ? -1 : (column + 0.5 - from.x) / way;
      if (share >= 0 && share <= 1) set(column, from.height + share * (to.height - from.height));
    }
    // The middle of the last column lies ahead, or the line goes straight up.
    if (way === 0 || (last + 0.5 - to.x) * way > 0) set(last, to.height);
    show(board, curve);
  };

  // ---- mouse and finger
  let stroke = null;
  const pointAt = (board, event) => {
    const box = board.querySelector(".paper").getBoundingClientRect();
    return {
      x: clamp((event.clientX - box.left) / box.width, 1) * columnsOf(board),
      height: clamp(1 - (event.clientY - box.top) / box.height, 1),
    };
  };
  const begin = (event) => {
    const board = event.target instanceof Element && event.target.closest(".duet-draw");
    if (!board || !event.isPrimary || event.button !== 0) return;
    event.preventDefault();
    board.focus({ preventScroll: true });
    board.setPointerCapture(event.pointerId);
    const point = pointAt(board, event);
    stroke = { board, pointer: event.pointerId, point };
    fill(board, point, point);
  };
  const go = (event) => {
    if (!stroke || event.pointerId !== stroke.pointer) return;
    const passed = event.getCoalescedEvents?.() ?? [];
    for (const one of passed.length ? passed : [event]) {
      const point = pointAt(stroke.board, one);
      fill(stroke.board, stroke.point, point);
      stroke.point = point;
    }
  };
  const end = (event) => {
    if (!stroke || event.pointerId !== stroke.pointer) return;
    send(stroke.board);
    stroke = null;
  };
  addEventListener("pointerdown", begin, true);
  addEventListener("pointermove", go, true);
  addEventListener("pointerup", end, true);
  addEventListener("pointercancel", end, true);

  // ---- keys: a cursor moves along; a height that is set behind a gap is joined to the last one by a straight line
  let resting = 0;
  let unsent = null;
  const flush = () => {
    clearTimeout(resting);
    if (unsent) send(unsent);
    unsent = null;
  };
  const say = (board, column) => {
    const [x, y] = [JSON.parse(board.dataset.x), JSON.parse(board.dataset.y)];
    const text = ([symbol, low, high, unit, digits], share) =>
      `${symbol} = ${(low + share * (high - low)).toFixed(digits).replace(".", board.dataset.point)} ${unit}`.trim();
    const height = curveOf(board)[column];
    const parts = [text(x, (column + 0.5) / columnsOf(board))];
    if (height !== null) parts.push(text(y, height));
    board.parentElement.querySelector("[role=status]").textContent = parts.join(", ");
  };
  const point = (board, column) => {
    let cursor = board.querySelector(".cursor");
    if (!cursor) {
      cursor = area(board).querySelector(".pencil").cloneNode();
      cursor.setAttribute("class", "cursor");
      area(board).append(cursor);
    }
    cursor.setAttribute("d", `M${column + 0.5} 0v1`);
    board.dataset.column = column;
    say(board, column);
  };
  const clear = (board) => {
    board.dataset.from = "";
    show(board, []);
    send(board);
  };
  const press = (event) => {
    const board = event.target instanceof Element && event.target.closest(".duet-draw");
    if (!board || event.ctrlKey || event.metaKey || event.altKey) return;
    const most = columnsOf(board) - 1;
    const column = Number(board.dataset.column ?? 0);
    const far = event.shiftKey ? FAR : 1;
    const to = { ArrowLeft: column - far, ArrowRight: column + far, Home: 0, End: most }[event.key];
    const up = { ArrowUp: STEP * far, ArrowDown: -STEP * far, PageUp: STEP * FAR, PageDown: -STEP * FAR }[event.key];
    if (to !== undefined) {
      if (curveOf(board)[column] !== null) board.dataset.from = column;
      point(board, clamp(to, most));
    } else if (up !== undefined) {
      const curve = curveOf(board);
      const from = board.dataset.from ? Number(board.dataset.from) : column;
      const old = curve[column] ?? curve[from] ?? 0.5;
      const next = { x: column + 0.5, height: clamp(old + up, 1) };
      fill(board, curve[from] === null ? next : { x: from + 0.5, height: curve[from] }, next);
      point(board, column);
      unsent = board;
      clearTimeout(resting);
      resting = setTimeout(flush, KEYS_REST_MS);
    } else if (event.key === "Delete" || event.key === "Backspace") {
      clear(board);
      point(board, column);
    } else return;
    event.preventDefault();
    event.stopImmediatePropagation();
  };
  addEventListener("keydown", press, true);
  addEventListener("focusout", flush, true);
  const onClick = ({ target }) => {
    const button = target instanceof Element && target.closest(".duet-clear");
    if (button) clear(button.closest(".duet-l-drawing").querySelector(".duet-draw"));
  };
  addEventListener("click", onClick, true);
})();
