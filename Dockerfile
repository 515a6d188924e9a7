# The benchmark with its locked environment and PyTorch's build for processors. No GPU is needed.
#   docker build -t cycleik-bench .
#   docker run --rm -v "$PWD/results:/bench/results" cycleik-bench make demo
FROM python:3.11-slim-bookworm
RUN apt-get update \
    && apt-get install -y --no-install-recommends git make flite espeak-ng \
    && rm -rf /var/lib/apt/lists/*
WORKDIR /bench
COPY requirements.lock requirements.hashes pyproject.toml ./
# The environment first: its layer is kept as long as the lock and the project file stay as they are.
RUN python -m venv .venv \
    && .venv/bin/pip install --no-cache-dir --no-deps --index-url https://download.pytorch.org/whl/cpu \
        "$(grep '^torch==' requirements.lock)" \
    && .venv/bin/pip install --no-cache-dir --no-deps --require-hashes -r requirements.hashes
COPY . .
RUN .ci/environment && .venv/bin/python -m pipeline warm
CMD ["make", "help"]
