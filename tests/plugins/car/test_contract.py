"""The contract suite on the car modeler."""

from __future__ import annotations

import numpy as np

from bozzetto.scene import Picture
from bozzetto.testing import ModelerContract, Pen, Shell
from bozzetto_car.body.build import body_of
from bozzetto_car.marking.next_mark import asked_of
from bozzetto_car.modeler import Car
from bozzetto_car.template.loader import bundled
from tests.plugins.car.sketched import FRONT_QUARTER, PICTURE, looking, styled

TEMPLATE = bundled("sedan")


class TestCar(ModelerContract):
    modeler = "bozzetto.car"

    def sketch(self, shell: Shell, pen: Pen) -> None:
        """A picture is placed, and ten points are marked as they are asked for."""
        car = styled(TEMPLATE, pen.seed)
        seen = looking(car, FRONT_QUARTER, np.random.default_rng(pen.seed)).project(car)[0]
        width, height = (int(side) for side in PICTURE)
        paper = np.full((height, width, 4), 240, np.uint8)
        picture = Picture.of(paper, "Sedan")
        shell.put(Car().add_picture(shell.state, picture, shell.context()))
        for _ in range(10):
            body = body_of(shell.state)
            asked = asked_of(shell.state, body.solved)
            assert asked is not None
            sketch_camera = body.sketch_cameras[shell.state.sketch.id]
            shell.camera = sketch_camera.view(PICTURE)
            place = sketch_camera.lifted(seen[[TEMPLATE.node[asked.node]]])
            x, y = shell.camera.project(place)[0][0]
            shell.tap(float(x), float(y))
