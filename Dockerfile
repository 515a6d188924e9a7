# The benchmark with its locked environment. No GPU is needed; the lock takes PyTorch from the index that pip is given.
#   docker build -t cycleik-bench .
#   docker run --rm -v "$PWD/results:/bench/results" cycleik-bench make demo
FROM python:3.11-slim-bookworm
RUN apt-get update \
    && apt-get install -y --no-install-recommends git make flite espeak-ng \
    && rm -rf /var/lib/apt/lists/*
WORKDIR /bench
COPY requirements.lock pyproject.toml ./
# The environment first: its layer is kept as long as the lock and the project file stay as they are.
RUN python -m venv .venv \
    && .venv/bin/pip install --no-cache-dir --prefer-binary -r requirements.lock
COPY . .
RUN .ci/environment && .venv/bin/python -m pipeline warm
CMD ["make", "help"]
