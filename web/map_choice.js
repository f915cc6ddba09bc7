// The environment maps: the choice among those of the server, and uploads of one's own.
import { getJson, uploadMap } from "./api.js";
import { controlFor, controlsFor } from "./controls.js";
import { $ } from "./dom.js";

const kHeading = { type: "number", minimum: -180, maximum: 180,
                   description: "rotation of the environment map about the vertical axis in degrees" };

export class MapChoice {
  // Draws the controls of `environment`. maps: `environments` of the server's list.
  constructor(session, changed, maps) {
    Object.assign(this, { session, changed });
    this.#draw(maps);
  }

  #draw(maps) {
    const { session, changed } = this;
    const { rotation, ...light } = session.schema.properties.environment.properties;
    const map = { ...light.map, enum: maps.map((m) => m.name), "x-titles": maps.map((m) => m.title) };
    controlsFor($("light"), { ...light, map }, session.environment, changed, { map: "of the scene" });
    if (!rotation) return;
    $("light").append(controlFor("heading", kHeading, session.headingDegrees, (value) => {
      session.headingDegrees = value ?? 0;
      changed();
    }));
  }

  // Uploads a map and lights the scene with it. Throws a Problem.
  async open({ name, file }, onProgress) {
    this.session.environment.map = await uploadMap(file, name, onProgress);
    this.#draw((await getJson("v1/environments")).environments);
    this.changed();
  }
}
