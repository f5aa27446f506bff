"""Models compiled in several threads at once."""

import sys
import threading

from tests.plugin.test_refusals import LAW, compiled, instance

THREADS, TIMES = 4, 50


def test_each_thread_is_told_of_its_own_model():
    told = [[] for _ in range(THREADS)]
    start = threading.Barrier(THREADS)

    def compile_repeatedly(thread):
        start.wait()
        for _ in range(TIMES):
            try:
                compiled(instance(f"bad{thread}", **(LAW | {"tendon": f"none{thread}"})))
            except ValueError as error:
                told[thread].append(str(error))

    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        threads = [threading.Thread(target=compile_repeatedly, args=(k,)) for k in range(THREADS)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    finally:
        sys.setswitchinterval(interval)
    for thread, errors in enumerate(told):
        assert len(errors) == TIMES
        assert all(f"instance 'bad{thread}': unknown tendon 'none{thread}'" in e for e in errors)
