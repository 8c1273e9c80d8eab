// Colours for XML and YAML: enough to see where a tag ends. A line at a time, and never markup of the text's own.

const XML = /(<!--[\s\S]*?(?:-->|$))|(<\/?[\w:.-]+|\/?>)|([\w:.-]+)(?==)|("[^"]*"|'[^']*')/g;
const YAML = /(#[^\n]*)|()|(^[ \t-]*[\w. ]+(?=:(?:\s|$)))|("[^"\n]*"|'[^'\n]*'|\{[^}\n]*\})/gm;
const KINDS = ["t-comment", "t-tag", "t-name", "t-value"];

export function highlighted(text, xml) {
  const out = document.createDocumentFragment();
  const pattern = new RegExp(xml ? XML : YAML);
  let last = 0;
  for (let match = pattern.exec(text); match; match = pattern.exec(text)) {
    if (match[0] === "") {
      pattern.lastIndex++;
      continue;
    }
    const kind = KINDS[match.slice(1).findIndex((group) => group)];
    if (match.index > last) out.append(text.slice(last, match.index));
    const span = document.createElement("span");
    span.className = kind;
    span.textContent = match[0];
    out.append(span);
    last = match.index + match[0].length;
  }
  out.append(text.slice(last));
  return out;
}
