// A lesson is marked as ready in its first line, before the rest of it is read.
while (page.document.readyState !== "complete") await wait(20);
frame.width = 390;
page.document.querySelectorAll("details").forEach(part => { part.open = true; });
await wait(300);
const { body, documentElement } = page.document, tables = [...page.document.querySelectorAll("table")];
return {
  wide: documentElement.scrollWidth, tables: tables.length, scheme: page.getComputedStyle(documentElement).colorScheme, background: page.getComputedStyle(body).backgroundColor,
  // Where the columns of a table touch, their words run together.
  tight: tables.filter(table => [...table.querySelectorAll("td:not(:last-child)")].some(cell => parseFloat(page.getComputedStyle(cell).paddingRight) < 5)).length,
};
