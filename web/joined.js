// Names in views that join several scenes. Pure.

// The scene of the view that a request shows; others may be joined to it.
export const sceneIdOf = (scene) => (Array.isArray(scene) ? scene[0]?.scene : scene);

// The name of a node without that of the scene before it.
export const withoutScene = (name, id) => (name.startsWith(`${id}/`) ? name.slice(id.length + 1) : name);

// The word with the first number that makes a free name.
export function numbered(word, isTaken) {
  let number = 1;
  while (isTaken(`${word} ${number}`)) ++number;
  return `${word} ${number}`;
}
