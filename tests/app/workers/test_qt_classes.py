"""Classes of Qt are made before a worker asks for them."""

from __future__ import annotations

import json
import subprocess
import sys

MAKE = """
import json, threading, time
from PySide6 import QtCore, QtGui, QtWidgets
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication

from bozzetto_app.workers import qt_classes

application = QApplication([])
application.setApplicationName("made")  # what a program has asked for is there already
modules = (QtCore, QtGui, QtWidgets)

def left():
    return [sum(name not in vars(module) for name in dir(module)) for module in modules]

before, turns, after = left(), [], []
classes = qt_classes.QtClasses(application)
ticker = QTimer(interval=0)
ticker.timeout.connect(lambda: turns.append(time.monotonic()))
ticker.start()

def seen():
    worker = threading.Thread(target=__import__, args=("pyqtgraph",))
    here = left()
    worker.start()
    worker.join()
    after.extend((here, left()))
    application.quit()

classes.made.connect(seen)
classes.start()
assert left() == before, "nothing is done before the window's thread is free"
application.exec()
print(json.dumps({"before": before, "after": after, "turns": len(turns)}))
"""


def test_none_is_left_when_a_worker_begins_and_the_window_goes_on_meanwhile():
    done = subprocess.run(
        [sys.executable, "-c", MAKE], capture_output=True, text=True, check=True, timeout=120
    )
    said = json.loads(done.stdout.splitlines()[-1])
    assert min(said["before"]) > 100
    assert said["after"] == [[0, 0, 0], [0, 0, 0]]
    assert said["turns"] > 5
