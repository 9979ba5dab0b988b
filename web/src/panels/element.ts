type Attributes = Record<string, string | number | boolean | undefined>;

/** Creates an element with attributes and content. An attribute that is false or undefined is omitted. */
export function element<Tag extends keyof HTMLElementTagNameMap>(
  tag: Tag,
  attributes: Attributes = {},
  ...content: (Node | string)[]
): HTMLElementTagNameMap[Tag] {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== undefined && value !== false) made.setAttribute(name, value === true ? "" : String(value));
  }
  made.append(...content);
  return made;
}

/** Creates a button with a label. */
export function button(label: string, icon: Node | string, onPress: () => void, style = "icon"): HTMLButtonElement {
  const made = element("button", { type: "button", class: style, "aria-label": label, title: label }, icon);
  made.addEventListener("click", onPress);
  return made;
}

/** Creates a collapsible section of the panel. */
export function section(title: Node | string, isOpen: boolean, ...content: Node[]): HTMLDetailsElement {
  const details = element("details", { class: "section" }, element("summary", {}, title), ...content);
  details.open = isOpen;
  return details;
}

/** Creates a spot of colour, which screen readers skip. */
export function swatch(colour: string): HTMLElement {
  const made = element("span", { class: "swatch", "aria-hidden": "true" });
  made.style.background = colour;
  return made;
}
