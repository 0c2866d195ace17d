// SPDX-License-Identifier: Apache-2.0

/** An element with attributes (functions become listeners) and children (elements or text). */
export function element(tag, attributes = {}, ...children) {
  const result = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === 'function') result.addEventListener(name.replace(/^on/, ''), value);
    else if (value === true) result.setAttribute(name, '');
    else if (value !== false && value !== null && value !== undefined) result.setAttribute(name, value);
  }
  result.append(...children.filter((child) => child !== null && child !== undefined));
  return result;
}

let count = 0;
/** A control with its label in front of it. */
export function labelled(text, control) {
  control.id ||= `control-${++count}`;
  return [element('label', { for: control.id }, text), control];
}

export function button(text, name, onclick, attributes = {}) {
  return element('button', { type: 'button', 'aria-label': name, title: name, onclick, ...attributes }, text);
}

export function select(name, options, onchange) {
  return element('select', { 'aria-label': name, onchange: (event) => onchange(event.target.value) },
    ...Object.entries(options).map(([value, text]) => element('option', { value }, text)));
}
