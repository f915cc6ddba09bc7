// An entry of a list of changes with another value of one field (undefined: without it), or with none of them (field:
// undefined). selector: the fields that say what it changes. -> the entry; undefined if it changes nothing any more.
export function withField(entry, selector, field, value) {
  if (field === undefined) return undefined;
  const changed = { ...selector, ...entry, [field]: value };
  if (value === undefined) delete changed[field];
  return Object.keys(changed).length > Object.keys(selector).length ? changed : undefined;
}

// The elements of a list by keyOf(element), in the order of first appearance: Map of key to elements.
export function grouped(list, keyOf) {
  const groups = new Map();
  for (const each of list) {
    const key = keyOf(each);
    if (groups.has(key)) groups.get(key).push(each);
    else groups.set(key, [each]);
  }
  return groups;
}
