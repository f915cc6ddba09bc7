// A client of the server with types that are generated from its OpenAPI document. client.test.mjs compiles it with
// --strict and runs it.
import createClient from "openapi-fetch";
import type { components, paths } from "./clerestory.js";

type FrameRequest = components["schemas"]["FrameRequest"];

// Every field is optional; a filter has the fields of its type.
export const smallFrame: FrameRequest = {
  width: 64, height: 48, effects: { emission: false }, accuracy: "draft",
  filters: [{ type: "twirl", amount: 1 }, { type: "glow" }, { type: "convolve", kernel: [0, 0, 0, 0, 1, 0, 0, 0, 0] }],
};

export const wrongFrames: FrameRequest[] = [
  // @ts-expect-error: amount is required.
  { filters: [{ type: "twirl" }] },
  // @ts-expect-error: a glow has no amount.
  { filters: [{ type: "glow", amount: 1 }] },
  // @ts-expect-error: no such preset.
  { accuracy: "best" },
];

export async function drawFrame(baseUrl: string, frame: FrameRequest) {
  const client = createClient<paths>({ baseUrl });
  const scenes = await client.GET("/v1/scenes");
  if (!scenes.data) throw new Error(scenes.error.detail);
  const scene: string | undefined = scenes.data.scenes.find((s) => s.default)?.id;
  if (scene === undefined) throw new Error("there is no default scene");
  const body = { ...frame, scene };
  const plan = await client.POST("/v1/plans", { body });
  if (!plan.data) throw new Error(plan.error.detail);
  const kinds: string[] = plan.data.passes.map((pass) => pass.kind);
  const picture = await client.POST("/v1/frames", { body, parseAs: "arrayBuffer" });
  if (!picture.data) throw new Error(picture.error.detail);
  return { kinds, jpeg: picture.data };
}

// -> the pointers of the fields that the server refuses.
export async function refusedFields(baseUrl: string, body: FrameRequest) {
  const { error, response } = await createClient<paths>({ baseUrl }).POST("/v1/plans", { body });
  return { status: response.status, code: error?.code, pointers: error?.errors?.map((field) => field.pointer) };
}

// Waits for a comparison of two presets. -> relMSE of each
export async function compare(baseUrl: string, frame: FrameRequest) {
  const client = createClient<paths>({ baseUrl });
  const { filters, ...view } = frame;
  const started = await client.POST("/v1/comparisons", { body: { ...view, settings: ["draft", "fine"], samples: 2, frames: 1 } });
  if (!started.data) throw new Error(started.error.detail);
  let job: components["schemas"]["Job"] = started.data;
  while (job.state === "queued" || job.state === "running") {
    await new Promise((resolve) => setTimeout(resolve, 20));
    const { data, error } = await client.GET("/v1/jobs/{id}", { params: { path: { id: job.id } } });
    if (!data) throw new Error(error.detail);
    job = data;
  }
  if (!job.result || !("settings" in job.result)) throw new Error(job.failure ?? "this is not the result of a comparison");
  return job.result.settings.map((setting) => setting.error.frame.relMse);
}
