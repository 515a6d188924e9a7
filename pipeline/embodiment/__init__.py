"""An agent with a body: it sees a table, is told what to do and does it in the simulator."""
