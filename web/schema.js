// From the OpenAPI schema of the server to controls, and from strings of a link to values. Pure. New fields of the server
// get controls without changes here.

// Ranges of sliders that are narrower than the allowed ones: [min, max].
const kSliderRanges = {
  exposure: [-6, 6], intensity: [0, 4], amount: [-6.28, 6.28], strength: [0, 4], threshold: [0, 8],
  radius: [0, 600],
};
const kSliderSteps = 200;

// planarReflection -> Planar reflection
export const labelOf = (name) => {
  const words = name.replace(/([A-Z])/g, (c) => ` ${c.toLowerCase()}`);
  return words[0].toUpperCase() + words.slice(1);
};

// The schema with every { $ref } replaced by what it refers to. Cycles are not supported.
export function resolved(schema, document) {
  if (Array.isArray(schema)) return schema.map((part) => resolved(part, document));
  if (schema === null || typeof schema !== "object") return schema;
  if (typeof schema.$ref === "string") {
    const target = schema.$ref.slice(2).split("/").reduce((at, name) => at[name], document);
    return resolved(target, document);
  }
  return Object.fromEntries(Object.entries(schema).map(([name, part]) => [name, resolved(part, document)]));
}

// The object among the alternatives of a value.
export const objectOf = (schema) => (schema.oneOf ?? [schema]).find((s) => s.type === "object") ?? schema;

// -> { kind: "switch" | "choice" | "range" | "vector" | "text" | "other", … }
export function controlOf(name, schema, sliderRange = kSliderRanges[name]) {
  const named = schema.oneOf?.find((s) => s.enum);
  if (named) return controlOf(name, named, sliderRange);  // the other forms are for programs
  if (schema.type === "boolean") return { kind: "switch" };
  if (schema.enum) return { kind: "choice", words: schema.enum, ...(schema["x-titles"] && { titles: schema["x-titles"] }) };
  if (schema.type === "array" && schema.items?.type === "number") {
    return { kind: "vector", count: schema.maxItems ?? schema.minItems ?? 3 };
  }
  if (schema.type === "string") return { kind: "text", maxLength: schema.maxLength };
  if (schema.type !== "number" && schema.type !== "integer") return { kind: "other" };
  const whole = schema.type === "integer";
  const [low, high] = sliderRange ?? [schema.minimum, schema.maximum];
  const min = Math.max(low, schema.minimum), max = Math.min(high, schema.maximum);
  return { kind: "range", whole, min, max, logarithmic: min > 0 && max / min >= 30,
           allowed: [schema.minimum, schema.maximum] };
}

// A slider has positions 0 … sliderSteps(); wide ranges are logarithmic.
export const sliderSteps = ({ whole, logarithmic, min, max }) =>
  whole && !logarithmic && max - min <= kSliderSteps ? max - min : kSliderSteps;

export function valueAt(control, position) {
  const { min, max, whole, logarithmic } = control;
  const t = position / sliderSteps(control);
  const value = logarithmic ? min * (max / min) ** t : min + (max - min) * t;
  return whole ? Math.round(value) : Number(value.toPrecision(3));
}

export function positionFor(control, value) {
  const { min, max, logarithmic } = control;
  const inside = Math.min(max, Math.max(min, value));
  const t = logarithmic ? Math.log(inside / min) / Math.log(max / min) : (inside - min) / (max - min);
  return Math.round(t * sliderSteps(control));
}

// A tagged union is a schema { oneOf: [{ properties: { type: { const: "twirl" }, … }, required }, …] }.
export const typesOf = (union) => union.oneOf.map((alternative) => alternative.properties.type.const);
const alternativeOf = (union, type) => union.oneOf.find((alternative) => alternative.properties.type.const === type);

// The schemas of an alternative's fields, without its type.
export function fieldsOfType(union, type) {
  const { type: _, ...fields } = alternativeOf(union, type)?.properties ?? {};
  return fields;
}

// The fields of an object; of a tagged union, those of all alternatives and the words of `type`.
export function propertiesOf(schema) {
  const forms = (schema.oneOf ?? []).filter((form) => form.properties?.type?.const !== undefined);
  if (!forms.length) return objectOf(schema).properties ?? {};
  return { ...Object.assign({}, ...forms.map((form) => form.properties)),
           type: { type: "string", enum: typesOf({ oneOf: forms }) } };
}

// A value of the alternative with its required fields: the first word, or the number nearest to 1.
export function newOfType(union, type) {
  const value = { type };
  for (const name of alternativeOf(union, type).required) {
    if (name === "type") continue;
    const control = controlOf(name, fieldsOfType(union, type)[name]);
    if (control.kind === "choice") value[name] = control.words[0];
    if (control.kind === "range") value[name] = Math.min(control.max, Math.max(control.min, 1));
  }
  return value;
}

// The defaults of all fields, including nested objects; lists and fields without a default are omitted.
export function defaultsOf(schema) {
  const values = {};
  for (const [name, field] of Object.entries(schema.properties ?? {})) {
    if (field.default !== undefined) values[name] = field.default;
    else if (field.type === "object") {
      const inner = defaultsOf(field);
      if (Object.keys(inner).length) values[name] = inner;
    }
  }
  return values;
}

// The text of a link as a value of the schema; undefined if it is invalid.
export function valueOf(schema, text) {
  if (schema.oneOf?.some((s) => s.enum?.includes(text))) return text;
  const count = text.split(",").length;
  const lists = schema.oneOf?.filter(({ type }) => type === "array") ?? [];
  const object = lists.find(({ items, minItems }) => items?.type === "number" && minItems === count)
    ?? (text.startsWith("[") ? lists.find(({ items }) => items?.type === "object") : undefined) ?? objectOf(schema);
  if (object.type === "boolean") return { true: true, false: false, 1: true, 0: false }[text];
  if (object.enum) return object.enum.includes(text) ? text : undefined;
  if (object.type === "number" || object.type === "integer") {
    return text.trim() !== "" && Number.isFinite(Number(text)) ? Number(text) : undefined;
  }
  if (object.type === "array" && object.items?.type === "number") {
    const list = text.split(",").map(Number);
    return list.every(Number.isFinite) ? list : undefined;
  }
  if (object.type === "array" || object.type === "object") {
    try {
      const value = JSON.parse(text);
      return Array.isArray(value) === (object.type === "array") ? value : undefined;
    } catch {
      return undefined;
    }
  }
  return text;
}
