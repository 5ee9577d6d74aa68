// Elements of the page, and numbers as people read them.

// An element with attributes (functions become listeners) and children: text
// stays text, whatever it holds.
export function h(tag, attributes, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) {
    if (typeof value === "function") element.addEventListener(name, value);
    else if (value !== null && value !== undefined) element.setAttribute(name, value);
  }
  element.append(...children.flat(4).filter((child) => child !== null && child !== undefined));
  return element;
}

export const isNumber = (value) => typeof value === "number" && Number.isFinite(value);

export function short(value, digits = 1) {
  if (!isNumber(value)) return "–";
  if (Math.abs(value) >= 1000) return Math.round(value).toLocaleString("en");
  return value.toFixed(Math.abs(value) >= 100 ? 0 : digits);
}
