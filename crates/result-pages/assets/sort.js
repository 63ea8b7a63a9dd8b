"use strict";
// Tables of class `sortable`: the button in a head sorts the rows by its column, a second time the other way.
for (const table of document.querySelectorAll("table.sortable")) {
  const heads = [...table.querySelectorAll("thead th")];
  heads.forEach((head, column) => {
    const button = head.querySelector("button");
    if (!button) return;
    button.addEventListener("click", () => {
      const ascending = head.getAttribute("aria-sort") !== "ascending";
      for (const other of heads) other.removeAttribute("aria-sort");
      head.setAttribute("aria-sort", ascending ? "ascending" : "descending");
      const sign = ascending ? 1 : -1;
      const compare = (a, b) => {
        const [x, y] = [a.cells[column], b.cells[column]];
        const [p, q] = [x.dataset.number, y.dataset.number];
        // A cell without a number comes last, whichever way.
        if (p !== undefined && q !== undefined) return sign * (Number(p) - Number(q));
        if (p !== undefined || q !== undefined) return p !== undefined ? -1 : 1;
        return sign * x.textContent.localeCompare(y.textContent, "en", { numeric: true });
      };
      const body = table.tBodies[0];
      body.append(...[...body.rows].sort(compare));
    });
  });
}
