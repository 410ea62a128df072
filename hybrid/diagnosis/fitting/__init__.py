"""The best parameters of one hypothesis, and what it forecasts."""
