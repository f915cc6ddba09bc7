// The environment maps: the choice among those of the server, and uploads of one's own.
import { getJson, uploadMap } from "./api.js";
import { controlFor, controlsFor } from "./controls.js";
import { $ } from "./dom.js";

const kHeading = { type: "number", minimum: -180, maximum: 180,
                   description: "rotation of the environment map about the vertical axis in degrees" };

export class MapChoice {
  #maps = [];

  constructor(session, changed) {
    Object.assign(this, { session, changed });
  }

  // Requests the list, and draws the controls of `environment`.
  async draw() {
    ({ environments: this.#maps } = await getJson("v1/environments"));
    const { session, changed } = this;
    const { rotation, ...light } = session.schema.properties.environment.properties;
    const map = { ...light.map, enum: this.#maps.map((m) => m.name), "x-titles": this.#maps.map(titleOf) };
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
    await this.draw();
    this.changed();
  }
}

// The name of an upload is a hash.
const titleOf = ({ name, title, source }) => (source === "uploaded" ? title : name);
