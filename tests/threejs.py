"""three.js as an independent reader and renderer, in a Chromium without a window.

BOZZETTO_THREE names the folder of the package ``three``; Chromium is looked for on the path.
"""

from __future__ import annotations

import base64
import io
import json
import os
import shutil
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import numpy as np
import pytest

SIDE = 512
"""Width and height of the pictures, pixels."""

PAGE = """<!doctype html><meta charset="utf-8"><pre id="answer"></pre>
<script type="importmap">{"imports": {"three": "/three/build/three.module.js"}}</script>
<script type="module">
import * as THREE from "three";
import { GLTFLoader } from "/three/examples/jsm/loaders/GLTFLoader.js";
const asked = ASKED;
const loaded = await new GLTFLoader().loadAsync("/model.glb");
const scene = new THREE.Scene();
scene.background = new THREE.Color(0xffffff);
scene.add(loaded.scene);
const renderer = new THREE.WebGLRenderer({antialias: false, preserveDrawingBuffer: true});
renderer.setSize(SIDE, SIDE, false);
const mixer = new THREE.AnimationMixer(loaded.scene);
for (const clip of loaded.animations) mixer.clipAction(clip).play();

function meshes() {
  const found = [];
  loaded.scene.traverse(one => { if (one.isMesh) found.push(one); });
  return found;
}

function places(mesh) {
  const row = [], place = new THREE.Vector3();
  for (let k = 0; k < mesh.geometry.attributes.position.count; k++) {
    mesh.getVertexPosition(k, place);
    row.push(...place.applyMatrix4(mesh.matrixWorld).toArray());
  }
  return row;
}

const frames = asked.times.map(time => {
  mixer.setTime(time);
  loaded.scene.updateMatrixWorld(true);
  return meshes().flatMap(places);
});
const box = new THREE.Box3().setFromObject(loaded.scene);
const answer = {
  frames, low: box.min.toArray(), high: box.max.toArray(), clips: loaded.animations.length,
  meshes: meshes().map(one => ({
    name: one.name, opacity: one.material.opacity, transparent: one.material.transparent,
    roughness: one.material.roughness, metalness: one.material.metalness,
    color: one.material.color.toArray(), material: one.material.uuid,
    map: one.material.map ? one.material.map.source.uuid : "",
  })),
};
if (asked.picture) {  // from the front, black on white
  const middle = box.getCenter(new THREE.Vector3());
  const half = 0.55 * Math.max(...box.getSize(new THREE.Vector3()).toArray());
  const camera = new THREE.OrthographicCamera(-half, half, half, -half, 0.01 * half, 100 * half);
  camera.position.copy(middle).add(new THREE.Vector3(0, 0, 10 * half));
  camera.lookAt(middle);
  if (asked.painted) {  // in the colours of the pictures, without light
    for (const one of meshes()) {
      const looks = {map: one.material.map, color: one.material.color};
      one.material = new THREE.MeshBasicMaterial(looks);
    }
  } else {
    const black = {color: 0x000000, side: THREE.DoubleSide};
    scene.overrideMaterial = new THREE.MeshBasicMaterial(black);
  }
  renderer.render(scene, camera);
  answer.half = half;
  answer.picture = renderer.domElement.toDataURL("image/png");
}
document.getElementById("answer").textContent = JSON.stringify(answer);
</script>"""


def asked(
    model: bytes, times: tuple[float, ...] = (), picture: bool = False, painted: bool = False
) -> Any:
    """Load a GLB file; the test is skipped where there is no three.js or no Chromium.

    Parameters
    ----------
    model : bytes
    times : tuple of float
        Seconds at which the vertices are told, in metres: "frames", a row of x, y, z each.
    picture : bool
        Whether "picture" shows it from the front, black on white, as an (SIDE, SIDE) array of
        whether there is something; "half" is half of its width, metres.
    painted : bool
        Whether it shows the colours instead, (SIDE, SIDE, 3).
    """
    three = os.environ.get("BOZZETTO_THREE")
    browser = shutil.which("chromium") or shutil.which("chromium-browser")
    if not three or not browser:
        pytest.skip("BOZZETTO_THREE names no three.js, or there is no Chromium")
    page = PAGE.replace(
        "ASKED", json.dumps({"times": times, "picture": picture or painted, "painted": painted})
    )
    files = {"/": page.replace("SIDE", str(SIDE)).encode(), "/model.glb": model}
    with _served(files, Path(three)) as address:
        done = subprocess.run(
            [
                browser, "--headless", "--no-sandbox", "--disable-quic", "--no-first-run",
                "--disable-background-networking", "--disable-component-update",
                "--disable-sync", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                "--ignore-gpu-blocklist", "--virtual-time-budget=60000", "--dump-dom", address,
            ],
            capture_output=True, text=True, check=True, timeout=180,
        )  # fmt: skip
    text = done.stdout.partition('<pre id="answer">')[2].partition("</pre>")[0]
    assert text, done.stderr[-2000:]
    answer = json.loads(text.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&"))
    answer["frames"] = [np.reshape(row, (-1, 3)) for row in answer["frames"]]
    if picture or painted:
        from PIL import Image

        image = Image.open(io.BytesIO(base64.b64decode(answer["picture"].partition(",")[2])))
        dark = np.asarray(image.convert("L")) < 128
        answer["picture"] = np.asarray(image.convert("RGB")) if painted else dark
    return answer


@contextmanager
def _served(files: dict[str, bytes], three: Path) -> Iterator[str]:
    """Serve a few files, and three.js below ``/three``, to this machine only."""

    class Handler(SimpleHTTPRequestHandler):
        def do_GET(self) -> None:
            if self.path in files:
                self.send_response(200)
                kind = "text/html" if self.path == "/" else "model/gltf-binary"
                self.send_header("Content-Type", kind)
                self.end_headers()
                self.wfile.write(files[self.path])
            elif self.path.startswith("/three/"):
                self.path = self.path.removeprefix("/three")
                super().do_GET()
            else:
                self.send_error(404)

        def log_message(self, format: str, *args: object) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Handler, directory=str(three)))
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/"
    finally:
        server.shutdown()
        thread.join()
        server.server_close()
