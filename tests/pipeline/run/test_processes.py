"""Processes that are started: they do not hear Ctrl-C, and this one hears it afterwards."""

import os
import signal
import subprocess
import sys

import pytest

from pipeline.run.processes import deaf_to_interrupts

_BLOCKED = "import signal; print(*(number.name for number in signal.pthread_sigmask(signal.SIG_BLOCK, [])))"


@pytest.mark.parametrize("send", [signal.raise_signal, lambda number: os.kill(os.getpid(), number)])
def test_an_interrupt_while_processes_start_comes_afterwards(send):
    before, reached = signal.getsignal(signal.SIGINT), False
    with pytest.raises(KeyboardInterrupt), deaf_to_interrupts():
        send(signal.SIGINT)
        said = subprocess.run([sys.executable, "-c", _BLOCKED], capture_output=True, text=True, check=True).stdout
        reached = True
    assert reached and {"SIGINT", "SIGHUP"} <= set(said.split())
    assert signal.getsignal(signal.SIGINT) is before
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])


def test_a_signal_that_was_ignored_stays_so():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with deaf_to_interrupts():
            signal.raise_signal(signal.SIGHUP)
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)
